/// What VTK's XML files of all kinds have in common: tags, arrays, the appended section.
#include "io/vtk_xml.h"

#include "io/number_text.h"
#include "io/xml_tag.h"

int lth_vtk_component(int components, int k) {
  // ours is xx yy zz yz zx xy, VTK's xx yy zz xy yz zx
  static const int symmetric[6] = {0, 1, 2, 5, 3, 4};
  return components == 6 ? symmetric[k] : k;
}

LitheStatus lth_vtk_encode_rows(LitheCtx *ctx, LitheCount n, int components, const double *data,
                                LthVtuBlock *block) {
  float *narrow = NULL;
  LitheCount count = n * components;
  LTH_NEW(ctx, narrow, count);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount i = 0; i < n; i++)
    for (int k = 0; k < components; k++)
      narrow[i * components + k] = (float)data[i * components + lth_vtk_component(components, k)];
  LitheStatus status = lth_vtu_block_encode(ctx, narrow, (LitheCount)sizeof *narrow * count, block);
  lth_free(ctx, narrow);
  return status;
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
