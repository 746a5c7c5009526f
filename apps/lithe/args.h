/// The command line: one command, its scene and its options.
#pragma once

#include <stdbool.h>

#define ARGS_MAX_SETS 256
#define ARGS_MAX_SWEEPS 8

/// Text is borrowed from argv.
typedef struct Args {
  const char *command;             ///< NULL: none was given
  const char *scene;               ///< or the name of a study; NULL where the command takes none
  const char *deck;                ///< of convert, or NULL
  const char *out;                 ///< -o, or NULL
  const char *resume;              ///< --resume, or NULL: there is no scene then
  const char *sets[ARGS_MAX_SETS]; ///< --set path=value, in order           (n_sets)
  int n_sets;
  const char *sweeps[ARGS_MAX_SWEEPS]; ///< --sweep path=value,value,...   (n_sweeps)
  int n_sweeps;
  bool json, quiet, quick, help, version;
  int threads;                          ///< 0: not given
  int step;                             ///< 0: not given
  const char *methods, *cells, *meshes; ///< of verify, or NULL
  double tolerance;                     ///< of verify, 0: not given
} Args;

/// Parse and check. On false a message has gone to standard error: exit with status 2.
bool args_parse(int argc, char **argv, Args *args);

/// Print the help of a command, or of the program where it is NULL.
void args_print_help(const char *command);
