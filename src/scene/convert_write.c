/// The scene of a deck as text, and the mesh file beside it that names what the deck does not.
#include "io/file.h"
#include "io/number_text.h"
#include "scene/convert.h"

#include <math.h>
#include <string.h>

#define PER_LINE 12

/// Text in double quotes, as YAML reads it; what is not plain ASCII becomes a question mark.
static void put_text(FILE *out, const char *text) {
  fputc('"', out);
  for (; *text; text++) {
    if (*text == '"' || *text == '\\') fputc('\\', out);
    fputc(*text >= ' ' && *text <= '~' ? *text : '?', out);
  }
  fputc('"', out);
}

static void put_number(FILE *out, double value) {
  char text[LTH_NUMBER_TEXT_MAX];
  fputs(lth_number_text(value == 0 ? 0 : value, text), out);
}

static void put_vector(FILE *out, const bool has[3], const double value[3]) {
  fputc('[', out);
  for (int a = 0; a < 3; a++) {
    if (a) fputs(", ", out);
    if (has[a])
      put_number(out, value[a]);
    else
      fputs("null", out);
  }
  fputc(']', out);
}

static void put_material(FILE *out, const LthConvertMaterial *m, const char *label) {
  fputs("{", out);
  if (label) {
    fputs("where: {label: ", out);
    put_text(out, label);
    fputs("}, ", out);
  }
  fputs("model: linear, young_modulus: ", out);
  put_number(out, m->young);
  fputs(", poisson_ratio: ", out);
  put_number(out, m->poisson);
  if (m->density > 0) {
    fputs(", density: ", out);
    put_number(out, m->density);
  }
  fputs("}", out);
}

/// The material of all elements, or -1.
static LitheIndex only_material(const LthConvert *c, const LitheIndex *material) {
  for (LitheIndex e = 1; e < c->mesh->n_elements; e++)
    if (material[e] != material[0]) return -1;
  return material[0];
}

/// In a scene the first match wins, in a deck the last section.
static LitheStatus put_materials(LthConvert *c, FILE *out) {
  LitheIndex *material = NULL;
  LITHE_TRY(lth_convert_element_materials(c, &material));
  LitheIndex only = only_material(c, material);
  fputs("    material:", out);
  if (only >= 0) {
    fputs(" ", out);
    put_material(out, &c->materials[only], NULL);
    fprintf(out, "  # %s\n", c->materials[only].name);
  } else {
    fputs("\n", out);
    for (LitheIndex s = c->n_sections; s-- > 0;) {
      fputs("      - ", out);
      put_material(out, &c->materials[c->sections[s].material], c->sections[s].elements->name);
      fprintf(out, "  # %s\n", c->materials[c->sections[s].material].name);
    }
  }
  lth_free(c->ctx, material);
  return LITHE_OK;
}

static void put_where(FILE *out, const LthConvertSet *set) {
  fputs("      - {where: {label: ", out);
  put_text(out, set->label);
  fputs("}, ", out);
}

static void put_holds(FILE *out, const LthConvertSets *holds) {
  if (holds->n > 0) fputs("    constraints:\n", out);
  for (LitheIndex i = 0; i < holds->n; i++) {
    put_where(out, &holds->set[i]);
    fputs("displacement: ", out);
    put_vector(out, holds->set[i].has, holds->set[i].value);
    fprintf(out, "}  # %d node%s\n", holds->set[i].n, holds->set[i].n > 1 ? "s" : "");
  }
}

/// rho w^2 (1 - a a^T) (x - p) by components.
static void put_centrifugal(FILE *out, const LthConvertBodyForce *force, double density) {
  fputs("      - {body_force: [", out);
  for (int i = 0; i < 3; i++) {
    bool any = false;
    fputs(i ? ", \"" : "\"", out);
    for (int j = 0; j < 3; j++) {
      double k = density * force->size * ((i == j) - force->axis[i] * force->axis[j]);
      if (k == 0) continue;
      if (any) fputs(" + ", out);
      any = true;
      put_number(out, k);
      fprintf(out, "*(%c %c ", "xyz"[j], force -> point[j] < 0 ? '+' : '-');
      put_number(out, fabs(force->point[j]));
      fputs(")", out);
    }
    fputs(any ? "\"" : "0\"", out);
  }
  fputs("]}  # CENTRIF\n", out);
}

static void put_loads(const LthConvert *c, FILE *out, const LthConvertScene *scene) {
  bool spins = false;
  for (LitheIndex i = 0; i < c->n_body_forces; i++) spins = spins || c->body_forces[i].spins;
  if (scene->forces.n + scene->pressures.n > 0 || spins) fputs("    loads:\n", out);
  for (LitheIndex i = 0; i < scene->forces.n; i++) {
    put_where(out, &scene->forces.set[i]);
    fputs("point_force: ", out);
    put_vector(out, scene->forces.set[i].has, scene->forces.set[i].value);
    LitheIndex n = scene->forces.set[i].n;
    if (n > 1)
      fprintf(out, "}  # on each of %d nodes\n", n);
    else
      fputs("}  # on 1 node\n", out);
  }
  for (LitheIndex i = 0; i < scene->pressures.n; i++) {
    put_where(out, &scene->pressures.set[i]);
    fputs("pressure: ", out);
    put_number(out, scene->pressures.set[i].value[0]);
    LitheIndex n = scene->pressures.set[i].n;
    fprintf(out, "}  # %d face%s\n", n, n > 1 ? "s" : "");
  }
  for (LitheIndex i = 0; i < c->n_body_forces; i++)
    if (c->body_forces[i].spins)
      put_centrifugal(out, &c->body_forces[i], c->materials[c->sections[0].material].density);
}

static void put_gravity(const LthConvert *c, FILE *out) {
  static const bool all[3] = {true, true, true};
  double g[3] = {0, 0, 0};
  for (LitheIndex i = 0; i < c->n_body_forces; i++)
    for (int a = 0; a < 3 && !c->body_forces[i].spins; a++)
      g[a] += c->body_forces[i].size * c->body_forces[i].axis[a];
  if (g[0] == 0 && g[1] == 0 && g[2] == 0) return;
  fputs("gravity: ", out);
  put_vector(out, all, g);
  fputs("\n", out);
}

LitheStatus lth_convert_write_scene(LthConvert *c, const LthConvertScene *scene) {
  LthFileWriter writer = {0};
  LITHE_TRY(lth_file_open(c->ctx, c->def->scene, &writer));
  FILE *out = writer.stream;
  LthTextLocale locale = lth_text_locale_begin();
  fprintf(out,
          "# %s, end of step %d, translated by lithe convert. Numbers are the deck's own, so that\n"
          "# lengths, forces and stresses are in its units: mm, N, MPa stay mm, N, MPa in the "
          "result.\n",
          c->def->deck, c->step);
  fputs("lithe: 1\n", out);
  if (c->title) {
    fputs("title: ", out);
    put_text(out, c->title);
    fputs("\n", out);
  }
  fputs("\nbodies:\n  - name: part\n    method:\n      kind: cg  # the deck's elements and nodes; "
        "dg: the "
        "same cells, degree 1 to 4\n      mesh: {file: ",
        out);
  put_text(out, scene->mesh);
  fputs("}\n", out);
  LitheStatus status = put_materials(c, out);
  put_holds(out, &scene->holds);
  put_loads(c, out, scene);
  fputs("\n", out);
  put_gravity(c, out);
  fputs("time: static\noutput: {fields: [vtu]}\n", out);
  lth_text_locale_end(locale);
  if (status != LITHE_OK) {
    lth_file_abandon(c->ctx, &writer);
    return status;
  }
  return lth_file_commit(c->ctx, &writer);
}

static void put_nodes(const LthConvert *c, FILE *out, const LthConvertSet *set) {
  fprintf(out, "*NSET, NSET=%s\n", set->own);
  for (LitheIndex i = 0; i < set->n; i++)
    fprintf(out, "%lld%s", (long long)c->mesh->node_id[set->member[i]],
            i + 1 == set->n || i % PER_LINE == PER_LINE - 1 ? "\n" : ", ");
}

static void put_faces(const LthConvert *c, FILE *out, const LthConvertSet *set) {
  fprintf(out, "*SURFACE, NAME=%s, TYPE=ELEMENT\n", set->own);
  for (LitheIndex i = 0; i < set->n; i++) {
    LitheIndex element = set->member[i] / LTH_CONVERT_FACES,
               local = set->member[i] % LTH_CONVERT_FACES;
    int number = 1;
    while (number < 6 && lth_inp_face((LthElementKind)c->mesh->kind[element], number) != local)
      number++;
    fprintf(out, "%lld, S%d\n", (long long)c->mesh->element_id[element], number);
  }
}

LitheStatus lth_convert_write_sets(LthConvert *c, const LthConvertScene *scene, const char *path,
                                   const char *deck) {
  const LthConvertSets *lists[] = {&scene->holds, &scene->forces, &scene->pressures};
  LthFileWriter writer = {0};
  LITHE_TRY(lth_file_open(c->ctx, path, &writer));
  fprintf(
      writer.stream,
      "** Nodes and faces that %s holds or loads, but does not name; written by lithe convert.\n"
      "*INCLUDE, INPUT=%s\n",
      c->def->deck, deck);
  for (int k = 0; k < 3; k++)
    for (LitheIndex i = 0; i < lists[k]->n; i++) {
      const LthConvertSet *set = &lists[k]->set[i];
      if (set->label != set->own) continue;
      if (set->of == LTH_GROUP_NODES)
        put_nodes(c, writer.stream, set);
      else
        put_faces(c, writer.stream, set);
    }
  return lth_file_commit(c->ctx, &writer);
}
