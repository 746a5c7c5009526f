/// `lithe convert`: translate a deck of another program into a scene.
#include "app.h"

#include <stdio.h>

static void print_text(const Args *args, const LitheConversion *c) {
  printf("%s: %d elements, %d nodes, %d material%s, %d support%s, %d load%s\n", args->deck,
         c->elements, c->nodes, c->materials, c->materials == 1 ? "" : "s", c->constraints,
         c->constraints == 1 ? "" : "s", c->loads, c->loads == 1 ? "" : "s");
  printf("  written         %s\n", args->scene);
  if (c->sets > 0)
    printf("  mesh            %s, with %d more set%s\n", c->mesh, c->sets, c->sets == 1 ? "" : "s");
  printf("  run it          lithe run %s\n", args->scene);
}

int cmd_convert(const Args *args) {
  App app;
  LitheConversion conversion = {0};
  LitheConvertDef def = lithe_convert_def_default();
  def.deck = args->deck;
  def.scene = args->scene;
  def.step = args->step;
  LitheStatus status = app_open_context(&app, args);
  if (status == LITHE_OK) status = lithe_convert(app.ctx, &def, &conversion);
  progress_end(&app.progress);
  if (status == LITHE_OK && !args->quiet) print_text(args, &conversion);
  return app_close(&app, status);
}
