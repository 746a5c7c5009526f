/// What this build of the library is: version, options, engines, licence.
#include "lithe/info.h"

#include "la/engine.h"

#define NLARGEFILE // else cholmod.h asks for 64-bit file calls after the system headers were read
#include <cholmod.h>
#include <libfyaml.h>
#include <omp.h>
#include <png.h>
#include <stdarg.h>
#include <stdio.h>
#include <zlib.h>

/// Text that grows to its full length but is written only where there is room.
typedef struct Lines {
  char *text;
  size_t size, length;
} Lines;

static void add(Lines *lines, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void add(Lines *lines, const char *format, ...) {
  bool fits = lines->length < lines->size;
  va_list args;
  va_start(args, format);
  int n = vsnprintf(fits ? lines->text + lines->length : NULL,
                    fits ? lines->size - lines->length : 0, format, args);
  va_end(args);
  if (n > 0) lines->length += (size_t)n;
}

static const char *yes_no(bool value) { return value ? "yes" : "no"; }

static void add_build(Lines *lines) {
  bool asserts = false, sanitizers = false;
#ifdef LITHE_ASSERTS
  asserts = true;
#endif
#ifdef __SANITIZE_ADDRESS__
  sanitizers = true;
#endif
  add(lines, "lithe       %s\n", lithe_version());
#if defined(__clang__)
  add(lines, "compiler    clang %d.%d.%d\n", __clang_major__, __clang_minor__,
      __clang_patchlevel__);
#else
  add(lines, "compiler    gcc %d.%d.%d\n", __GNUC__, __GNUC_MINOR__, __GNUC_PATCHLEVEL__);
#endif
#ifdef __OPTIMIZE__
  add(lines, "optimised   %s\n", yes_no(true));
#else
  add(lines, "optimised   %s\n", yes_no(false));
#endif
  add(lines, "asserts     %s\n", yes_no(asserts));
  add(lines, "sanitizers  %s\n", yes_no(sanitizers));
  add(lines, "threads     OpenMP, %d cores here\n", omp_get_num_procs());
}

static void add_engines(Lines *lines) {
  add(lines, "methods     dg (discontinuous Galerkin on polyhedra), cg (conforming elements),\n"
             "            staggered (variational finite differences on a grid)\n");
  add(lines, "engines    ");
  for (int i = 0; i < lth_engine_count(); i++) add(lines, " %s,", lth_engine_at(i)->name);
  add(lines, " pcg, multigrid\n");
  add(lines,
      "libraries   CHOLMOD %d.%d.%d, libfyaml %s, zlib %s, libpng %s, muParser, OpenBLAS, LAPACK\n",
      CHOLMOD_MAIN_VERSION, CHOLMOD_SUB_VERSION, CHOLMOD_SUBSUB_VERSION, fy_library_version(),
      zlibVersion(), png_get_libpng_ver(NULL));
}

static void add_licence(Lines *lines) {
  add(lines, "licence     MIT; linked with CHOLMOD's supernodal module, which is under the GPL (2 "
             "or later),\n"
             "            the program and a static build as a whole are covered by the GPL\n");
}

size_t lithe_info(char *text, size_t size) {
  Lines lines = {text, size, 0};
  if (size > 0) text[0] = 0;
  add_build(&lines);
  add_engines(&lines);
  add_licence(&lines);
  return lines.length;
}
