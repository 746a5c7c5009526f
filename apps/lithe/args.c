/// The command line: one command, its scene and its options.
#include "args.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RUN = 1, CHECK = 2, MESH = 4, INFO = 8, CONVERT = 16, STUDY = 32, VERIFY = 64, ALL = 127 };

static const struct {
  const char *name;
  int bit;
  int n_words; ///< 1: a scene; 2: a deck, then a scene; -1: a scene or a name, or none
  const char *usage, *purpose;
} commands[] = {
    {"run", RUN, 1, "lithe run SCENE [-o DIR] [options]\n       lithe run --resume DIR [options]",
     "run a scene and write its result"},
    {"check", CHECK, 1, "lithe check SCENE [options]",
     "check a scene and say what a run would need"},
    {"mesh", MESH, 1, "lithe mesh SCENE [-o FILE.vtu] [options]",
     "make the mesh only, report its quality"},
    {"convert", CONVERT, 2, "lithe convert DECK.inp SCENE.yaml [--step N]",
     "translate a CalculiX or Abaqus deck into a scene"},
    {"study", STUDY, -1,
     "lithe study [NAME | GROUP | all] [-o DIR] [options]\n"
     "       lithe study SCENE --sweep KEY=VALUE,VALUE,... [-o DIR] [options]",
     "compute a paper's figure or table anew, or sweep a scene's values"},
    {"verify", VERIFY, 1, "lithe verify SCENE [-o DIR] [options]",
     "run a scene by all methods at refining resolutions, say whether they agree"},
    {"info", INFO, 0, "lithe info", "print version, build options, engines and licence"},
};

static const struct {
  const char *name, *alias, *value; ///< value NULL: takes none
  int commands;
  const char *purpose;
} options[] = {
    {"--out", "-o", "PATH", RUN | MESH | STUDY | VERIFY,
     "where to write (run: a folder, out/<scene name> if not given)"},
    {"--resume", NULL, "DIR", RUN, "go on with an interrupted run from its last checkpoint"},
    {"--sweep", NULL, "KEY=LIST", STUDY,
     "values to run a scene with: --sweep bodies.0.method.cells=8,16,32"},
    {"--quick", NULL, NULL, STUDY, "coarser and shorter, the same questions"},
    {"--methods", NULL, "LIST", VERIFY,
     "methods to compare: --methods dg,staggered (all if not given)"},
    {"--cells", NULL, "LIST", VERIFY,
     "resolutions along the longest side: --cells 8,16,32 or 'dg:8,16;cg:16,32' (half, once, twice "
     "the scene's)"},
    {"--meshes", NULL, "LIST", VERIFY, "mesh files for cg, coarse to fine: --meshes a.msh,b.msh"},
    {"--tolerance", NULL, "SHARE", VERIFY,
     "how far methods may be apart: --tolerance 1% (stresses three times as far)"},
    {"--set", NULL, "KEY=VALUE", RUN | CHECK | MESH | STUDY | VERIFY,
     "override a value: --set bodies.0.method.degree=2"},
    {"--threads", NULL, "N", RUN | CHECK | MESH | STUDY | VERIFY,
     "threads to use (all cores if not given)"},
    {"--step", NULL, "N", CONVERT, "translate the end of this step (the last if not given)"},
    {"--json", NULL, NULL, RUN | CHECK | MESH | STUDY | VERIFY,
     "print the result as JSON on standard output"},
    {"--quiet", "-q", NULL, RUN | CHECK | MESH | CONVERT | STUDY | VERIFY,
     "print nothing but errors"},
    {"--help", "-h", NULL, ALL, "print this help"},
    {"--version", NULL, NULL, ALL, "print the version"},
};

#define COUNT(list) ((int)(sizeof(list) / sizeof(list)[0]))

/// Edit distance of two words (letters put in, left out, exchanged for another), at most 31 letters.
static int distance(const char *a, const char *b) {
  int row[32], n = (int)strlen(b);
  if (n > 31 || strlen(a) > 31) return 99;
  for (int j = 0; j <= n; j++) row[j] = j;
  for (int i = 1; a[i - 1]; i++) {
    int corner = row[0];
    row[0] = i;
    for (int j = 1; j <= n; j++) {
      int best = corner + (a[i - 1] != b[j - 1]);
      if (row[j] + 1 < best) best = row[j] + 1;
      if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
      corner = row[j];
      row[j] = best;
    }
  }
  return row[n];
}

static const char *nearest_command(const char *word) {
  int best = 0;
  for (int i = 1; i < COUNT(commands); i++)
    if (distance(word, commands[i].name) < distance(word, commands[best].name)) best = i;
  return commands[best].name;
}

static const char *nearest_option(const char *word, int bit) {
  const char *best = NULL;
  for (int i = 0; i < COUNT(options); i++)
    if ((options[i].commands & bit) &&
        (!best || distance(word, options[i].name) < distance(word, best)))
      best = options[i].name;
  return best;
}

static int find_command(const char *word) {
  for (int i = 0; i < COUNT(commands); i++)
    if (strcmp(word, commands[i].name) == 0) return i;
  return -1;
}

static int find_option(const char *word, size_t length) {
  for (int i = 0; i < COUNT(options); i++) {
    const char *name = options[i].name, *alias = options[i].alias;
    if ((strlen(name) == length && strncmp(word, name, length) == 0) ||
        (alias && strlen(alias) == length && strncmp(word, alias, length) == 0))
      return i;
  }
  return -1;
}

static bool set_threads(const char *value, Args *args) {
  char *end;
  long n = strtol(value, &end, 10);
  if (end == value || *end || n < 1 || n > 4096) {
    fprintf(stderr, "lithe: --threads: expected a number from 1 to 4096, got '%s'\n", value);
    return false;
  }
  args->threads = (int)n;
  return true;
}

static bool set_step(const char *value, Args *args) {
  char *end;
  long n = strtol(value, &end, 10);
  if (end == value || *end || n < 1 || n > 1000000) {
    fprintf(stderr, "lithe: --step: expected a number from 1 to 1000000, got '%s'\n", value);
    return false;
  }
  args->step = (int)n;
  return true;
}

static bool add_set(const char *value, Args *args) {
  const char *equals = strchr(value, '=');
  if (!equals || equals == value) {
    fprintf(stderr, "lithe: --set: expected KEY=VALUE, as in bodies.0.method.degree=2, got '%s'\n",
            value);
    return false;
  }
  if (args->n_sets == ARGS_MAX_SETS) {
    fprintf(stderr, "lithe: --set: at most %d values can be overridden\n", ARGS_MAX_SETS);
    return false;
  }
  args->sets[args->n_sets++] = value;
  return true;
}

static bool add_sweep(const char *value, Args *args) {
  if (args->n_sweeps == ARGS_MAX_SWEEPS) {
    fprintf(stderr, "lithe: --sweep: at most %d keys can be swept\n", ARGS_MAX_SWEEPS);
    return false;
  }
  args->sweeps[args->n_sweeps++] = value;
  return true;
}

/// "0.01" or "1%".
static bool set_tolerance(const char *value, Args *args) {
  char *end;
  double share = strtod(value, &end);
  if (end > value && strcmp(end, "%") == 0) {
    share /= 100;
    end++;
  }
  if (end == value || *end || !(share > 0 && share < 1)) {
    fprintf(stderr, "lithe: --tolerance: expected a share between 0 and 1, as in 1%%, got '%s'\n",
            value);
    return false;
  }
  args->tolerance = share;
  return true;
}

static bool apply(int option, const char *value, Args *args) {
  const char *name = options[option].name;
  if (strcmp(name, "--set") == 0) return add_set(value, args);
  if (strcmp(name, "--sweep") == 0) return add_sweep(value, args);
  if (strcmp(name, "--threads") == 0) return set_threads(value, args);
  if (strcmp(name, "--step") == 0) return set_step(value, args);
  if (strcmp(name, "--tolerance") == 0) return set_tolerance(value, args);
  if (strcmp(name, "--methods") == 0) args->methods = value;
  if (strcmp(name, "--cells") == 0) args->cells = value;
  if (strcmp(name, "--meshes") == 0) args->meshes = value;
  if (strcmp(name, "--out") == 0) args->out = value;
  if (strcmp(name, "--resume") == 0) args->resume = value;
  if (strcmp(name, "--quick") == 0) args->quick = true;
  if (strcmp(name, "--json") == 0) args->json = true;
  if (strcmp(name, "--quiet") == 0) args->quiet = true;
  if (strcmp(name, "--help") == 0) args->help = true;
  if (strcmp(name, "--version") == 0) args->version = true;
  return true;
}

/// One option at argv[*i], its value behind "=" or in the next word; moves *i on.
static bool parse_option(int argc, char **argv, int *i, int bit, Args *args) {
  const char *word = argv[*i], *value = NULL;
  const char *equals = word[1] == '-' ? strchr(word, '=') : NULL;
  size_t length = equals ? (size_t)(equals - word) : strlen(word);
  int option = find_option(word, length);
  if (option < 0 || !(options[option].commands & bit)) {
    fprintf(stderr, "lithe: unknown option '%s'%s%s; did you mean '%s'?\n", word,
            args->command ? " for " : "", args->command ? args->command : "",
            nearest_option(word, bit));
    return false;
  }
  if (options[option].value) {
    value = equals ? equals + 1 : *i + 1 < argc ? argv[++*i] : NULL;
    if (!value || !*value) {
      fprintf(stderr, "lithe: option '%s' needs a value: %s %s\n", word, options[option].name,
              options[option].value);
      return false;
    }
  } else if (equals) {
    fprintf(stderr, "lithe: option '%s' takes no value, got '%s'\n", options[option].name,
            equals + 1);
    return false;
  }
  return apply(option, value ? value : "", args);
}

static bool parse_word(const char *word, Args *args) {
  if (!args->command) {
    if (find_command(word) < 0) {
      fprintf(stderr, "lithe: unknown command '%s'; did you mean '%s'?\n", word,
              nearest_command(word));
      return false;
    }
    args->command = word;
    return true;
  }
  int n_words = commands[find_command(args->command)].n_words;
  if (n_words == 2 && !args->deck) {
    args->deck = word;
    return true;
  }
  if (args->scene || n_words == 0) {
    fprintf(stderr, "lithe: %s: one word too many: '%s'\nusage: %s\n", args->command, word,
            commands[find_command(args->command)].usage);
    return false;
  }
  args->scene = word;
  return true;
}

/// A run that goes on has its scene, its values and its folder already.
static bool is_only_resume(const Args *args) {
  const char *extra = args->scene    ? args->scene
                      : args->out    ? "--out"
                      : args->n_sets ? "--set"
                                     : NULL;
  if (!extra) return true;
  fprintf(stderr,
          "lithe: run: --resume DIR finds the scene, its values and its folder itself; leave "
          "'%s' out\n",
          extra);
  return false;
}

/// A command that takes files has them.
static bool is_complete(const Args *args) {
  if (args->help || args->version) return true;
  if (!args->command) {
    fprintf(stderr,
            "lithe: a command is missing: run, check, mesh, convert, study, verify or info; "
            "'lithe --help' says more\n");
    return false;
  }
  if (args->resume) return is_only_resume(args);
  if (args->n_sweeps > 0 && !args->scene) {
    fprintf(stderr, "lithe: study: --sweep needs a scene file\n");
    return false;
  }
  int command = find_command(args->command);
  if (commands[command].n_words <= 0 || args->scene) return true;
  bool no_deck = commands[command].n_words == 2 && !args->deck;
  fprintf(stderr, "lithe: %s: a %s file is missing\nusage: %s\n", args->command,
          no_deck ? "deck" : "scene", commands[command].usage);
  return false;
}

bool args_parse(int argc, char **argv, Args *args) {
  bool only_words = false;
  *args = (Args){0};
  for (int i = 1; i < argc; i++) {
    int bit = args->command ? commands[find_command(args->command)].bit : ALL;
    if (!only_words && strcmp(argv[i], "--") == 0) {
      only_words = true;
    } else if (!only_words && argv[i][0] == '-' && argv[i][1]) {
      if (!parse_option(argc, argv, &i, bit, args)) return false;
    } else if (!parse_word(argv[i], args)) {
      return false;
    }
  }
  return is_complete(args);
}

static void print_options(int bit) {
  printf("\nOptions:\n");
  for (int i = 0; i < COUNT(options); i++) {
    if (!(options[i].commands & bit)) continue;
    char left[40];
    snprintf(left, sizeof left, "%s%s%s%s%s", options[i].alias ? options[i].alias : "",
             options[i].alias ? ", " : "", options[i].name, options[i].value ? " " : "",
             options[i].value ? options[i].value : "");
    printf("  %-22s %s\n", left, options[i].purpose);
  }
}

void args_print_help(const char *command) {
  int c = command ? find_command(command) : -1;
  if (c >= 0) {
    printf("usage: %s\n\n%s\n", commands[c].usage, commands[c].purpose);
    print_options(commands[c].bit);
    return;
  }
  printf("usage: lithe COMMAND [SCENE] [options]\n\n"
         "Elastic solids without a conforming volume mesh.\n\nCommands:\n");
  for (int i = 0; i < COUNT(commands); i++)
    printf("  %-8s %s\n", commands[i].name, commands[i].purpose);
  print_options(ALL);
  printf("\nExit status: 0 done, 1 a check of a study does not hold, 2 bad usage or input, 3 did "
         "not converge, 4 out of memory or disk,\n"
         "130 interrupted.\n");
}
