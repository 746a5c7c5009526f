/// The program: chooses the command.
#include "app.h"

#include <stdio.h>
#include <string.h>

int main(int argc, char **argv) {
  static const struct {
    const char *name;
    int (*run)(const Args *args);
  } commands[] = {{"run", cmd_run},         {"check", cmd_check}, {"mesh", cmd_mesh},
                  {"convert", cmd_convert}, {"study", cmd_study}, {"verify", cmd_verify},
                  {"info", cmd_info}};
  Args args;
  if (!args_parse(argc, argv, &args)) return 2;
  if (args.help) {
    args_print_help(args.command);
    return 0;
  }
  if (args.version) {
    printf("lithe %s\n", lithe_version());
    return 0;
  }
  for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++)
    if (strcmp(args.command, commands[i].name) == 0) return commands[i].run(&args);
  return 2;
}
