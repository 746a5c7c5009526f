/// What the commands of the program share: a context with progress and signals, scenes, messages.
#pragma once

#include "args.h"
#include "progress.h"

#include "lithe/lithe.h"

typedef struct App {
  const Args *args;
  LitheCtx *ctx;
  LitheScene *scene;
  Progress progress;
} App;

/// Make the context alone, or with the scene that the arguments name.
LitheStatus app_open_context(App *app, const Args *args);
LitheStatus app_open(App *app, const Args *args);

/// Print what went wrong, if anything did, and the warnings; free all; return the exit status.
int app_close(App *app, LitheStatus status);

int cmd_run(const Args *args);
int cmd_check(const Args *args);
int cmd_mesh(const Args *args);
int cmd_convert(const Args *args);
int cmd_study(const Args *args);
int cmd_verify(const Args *args);
int cmd_info(const Args *args);
