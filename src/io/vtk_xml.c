/// What VTK's XML files of all kinds have in common: tags, arrays, the appended section.
#include "io/vtk_xml.h"

#include "io/number_text.h"
#include "io/xml_tag.h"

#include <string.h>

int lth_vtk_component(int components, int k) {
  // ours is xx yy zz yz zx xy, VTK's xx yy zz xy yz zx
  static const int symmetric[6] = {0, 1, 2, 5, 3, 4};
  return components == 6 ? symmetric[k] : k;
}

/// Floats of an array from number `first / 4` on.
static void fill_rows(const void *self, LitheCount first, LitheCount n, unsigned char *to) {
  const LthVtuArray *array = self;
  const int m = array->components;
  const LitheCount end = (first + n) / (LitheCount)sizeof(float);
  double room[LTH_VTK_COMPONENTS];
  const double *row = NULL;
  LitheCount at = -1;
  for (LitheCount i = first / (LitheCount)sizeof(float); i < end; i++, to += sizeof(float)) {
    if (i / m != at) row = lth_vtk_row(array, at = i / m, room);
    const float value = (float)row[lth_vtk_component(m, (int)(i % m))];
    memcpy(to, &value, sizeof value);
  }
}

LitheStatus lth_vtk_encode_array(LitheCtx *ctx, LitheCount n, const LthVtuArray *array,
                                 LthVtuBlock *block) {
  return lth_vtu_block_stream(ctx, fill_rows, array,
                              (LitheCount)sizeof(float) * n * array->components, block);
}

LitheStatus lth_vtk_encode_rows(LitheCtx *ctx, LitheCount n, int components, const double *data,
                                LthVtuBlock *block) {
  const LthVtuArray array = {.components = components, .data = data};
  return lth_vtk_encode_array(ctx, n, &array, block);
}

void lth_vtk_put_opening(FILE *out, const char *type) {
  fprintf(out,
          "<?xml version=\"1.0\"?>\n<VTKFile type=\"%s\" version=\"1.0\" "
          "byte_order=\"" LTH_VTK_BYTE_ORDER "\" header_type=\"UInt64\" "
          "compressor=\"vtkZLibDataCompressor\">\n",
          type);
}

void lth_vtk_put_end(FILE *out) { fputs("\n  </AppendedData>\n</VTKFile>\n", out); }

void lth_vtk_put_time(FILE *out, double time) {
  char text[LTH_NUMBER_TEXT_MAX];
  fprintf(out,
          "    <FieldData>\n      <DataArray type=\"Float64\" Name=\"TimeValue\" "
          "NumberOfTuples=\"1\" format=\"ascii\">%s</DataArray>\n    </FieldData>\n",
          lth_number_text(time, text));
}

void lth_vtk_put_array(FILE *out, const char *type, const char *name, int components,
                       const LthVtuBlock *block, LitheCount *offset) {
  fprintf(out, "        <DataArray type=\"%s\" Name=\"", type);
  lth_xml_put_text(out, name);
  fprintf(out, "\" NumberOfComponents=\"%d\" format=\"appended\" offset=\"%lld\"/>\n", components,
          (long long)*offset);
  *offset += block->size;
}

void lth_vtk_put_arrays(FILE *out, const char *section, int n, const LthVtuArray *arrays,
                        const LthVtuBlock *blocks, LitheCount *offset) {
  fprintf(out, "      <%s>\n", section);
  for (int i = 0; i < n; i++)
    lth_vtk_put_array(out, "Float32", arrays[i].name, arrays[i].components, blocks + i, offset);
  fprintf(out, "      </%s>\n", section);
}

void lth_vtk_put_appended(FILE *out) { fputs("  <AppendedData encoding=\"raw\">\n_", out); }

void lth_vtk_put_block(FILE *out, const LthVtuBlock *block) {
  fwrite(block->bytes, 1, (size_t)block->size, out);
}
