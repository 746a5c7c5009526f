/// VTU files of polyhedral fields (compressed appended data) and the PVD collection.
///
/// Written as https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html lays down: an XML head
/// whose DataArrays carry offsets into one appended, raw, zlib-compressed section.
#include "io/vtu.h"

#include "io/file.h"
#include "io/number_text.h"
#include "io/vtu_topology.h"

#include <stdio.h>

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
#define BYTE_ORDER_NAME "BigEndian"
#else
#define BYTE_ORDER_NAME "LittleEndian"
#endif

/// Where ours (xx yy zz yz zx xy) stand in VTK's order (xx yy zz xy yz zx).
static const int vtk_symmetric[6] = {0, 1, 2, 5, 3, 4};

/// Convert n rows to floats and compress them.
static LitheStatus encode_floats(LitheCtx *ctx, LitheCount n, int components, const double *data,
                                 LthVtuBlock *block) {
  float *narrow = NULL;
  LitheCount count = n * components;
  LTH_NEW(ctx, narrow, count);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount i = 0; i < n; i++)
    for (int k = 0; k < components; k++)
      narrow[i * components + k] =
          (float)data[i * components + (components == 6 ? vtk_symmetric[k] : k)];
  LitheStatus status = lth_vtu_block_encode(ctx, narrow, (LitheCount)sizeof *narrow * count, block);
  lth_free(ctx, narrow);
  return status;
}

static void put_escaped(FILE *out, const char *text) {
  for (; *text; text++) {
    if (*text == '<')
      fputs("&lt;", out);
    else if (*text == '>')
      fputs("&gt;", out);
    else if (*text == '&')
      fputs("&amp;", out);
    else if (*text == '"')
      fputs("&quot;", out);
    else
      fputc(*text, out);
  }
}

/// One DataArray element; `offset` moves on by the block's bytes.
static void put_array(FILE *out, const char *type, const char *name, int components,
                      const LthVtuBlock *block, LitheCount *offset) {
  fprintf(out, "        <DataArray type=\"%s\" Name=\"", type);
  put_escaped(out, name);
  fprintf(out, "\" NumberOfComponents=\"%d\" format=\"appended\" offset=\"%lld\"/>\n", components,
          (long long)*offset);
  *offset += block->size;
}

static void put_arrays(FILE *out, const char *section, int n, const LthVtuArray *arrays,
                       const LthVtuBlock *blocks, LitheCount *offset) {
  fprintf(out, "      <%s>\n", section);
  for (int i = 0; i < n; i++)
    put_array(out, "Float32", arrays[i].name, arrays[i].components, blocks + i, offset);
  fprintf(out, "      </%s>\n", section);
}

static void put_cells(FILE *out, const LthVtuTopology *topology, LitheCount *offset) {
  static const char *const names[LTH_VTU_TOPOLOGY_ARRAYS] = {"connectivity", "offsets", "types",
                                                             "faces", "faceoffsets"};
  fputs("      <Cells>\n", out);
  for (int i = 0; i < LTH_VTU_TOPOLOGY_ARRAYS; i++)
    put_array(out, i == 2 ? "UInt8" : "Int64", names[i], 1, topology->block + i, offset);
  fputs("      </Cells>\n", out);
}

/// `blocks` holds the points, then the point arrays, then the cell arrays: the order of the file.
static void put_head(FILE *out, const LthVtu *vtu, const LthVtuTopology *topology,
                     const LthVtuBlock *blocks) {
  char time[LTH_NUMBER_TEXT_MAX];
  LitheCount offset = 0;
  fputs("<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
        "byte_order=\"" BYTE_ORDER_NAME "\" header_type=\"UInt64\" "
        "compressor=\"vtkZLibDataCompressor\">\n  <UnstructuredGrid>\n",
        out);
  fprintf(out,
          "    <FieldData>\n      <DataArray type=\"Float64\" Name=\"TimeValue\" "
          "NumberOfTuples=\"1\" format=\"ascii\">%s</DataArray>\n    </FieldData>\n",
          lth_number_text(vtu->time, time));
  fprintf(out, "    <Piece NumberOfPoints=\"%d\" NumberOfCells=\"%d\">\n", vtu->n_points,
          vtu->mesh->n_cells);
  fputs("      <Points>\n", out);
  put_array(out, vtu->wide_points ? "Float64" : "Float32", "Points", 3, blocks, &offset);
  fputs("      </Points>\n", out);
  put_arrays(out, "PointData", vtu->n_point_arrays, vtu->point_arrays, blocks + 1, &offset);
  put_arrays(out, "CellData", vtu->n_cell_arrays, vtu->cell_arrays,
             blocks + 1 + vtu->n_point_arrays, &offset);
  put_cells(out, topology, &offset);
  fputs("    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n_", out);
}

static void put_block(FILE *out, const LthVtuBlock *block) {
  fwrite(block->bytes, 1, (size_t)block->size, out);
}

static LitheStatus put_file(LitheCtx *ctx, const char *path, const LthVtu *vtu,
                            const LthVtuTopology *topology, const LthVtuBlock *blocks,
                            int n_blocks) {
  LthFileWriter writer;
  LITHE_TRY(lth_file_open(ctx, path, &writer));
  put_head(writer.stream, vtu, topology, blocks);
  for (int i = 0; i < n_blocks; i++) put_block(writer.stream, blocks + i);
  for (int i = 0; i < LTH_VTU_TOPOLOGY_ARRAYS; i++) put_block(writer.stream, topology->block + i);
  fputs("\n  </AppendedData>\n</VTKFile>\n", writer.stream);
  return lth_file_commit(ctx, &writer);
}

static LitheStatus encode_fields(LitheCtx *ctx, const LthVtu *vtu, LthVtuBlock *blocks) {
  if (vtu->wide_points)
    LITHE_TRY(lth_vtu_block_encode(ctx, vtu->points,
                                   3 * (LitheCount)sizeof *vtu->points * vtu->n_points, blocks++));
  else
    LITHE_TRY(encode_floats(ctx, vtu->n_points, 3, vtu->points, blocks++));
  for (int i = 0; i < vtu->n_point_arrays; i++) {
    const LthVtuArray *a = vtu->point_arrays + i;
    LITHE_TRY(encode_floats(ctx, vtu->n_points, a->components, a->data, blocks++));
  }
  for (int i = 0; i < vtu->n_cell_arrays; i++) {
    const LthVtuArray *a = vtu->cell_arrays + i;
    LITHE_TRY(encode_floats(ctx, vtu->mesh->n_cells, a->components, a->data, blocks++));
  }
  return LITHE_OK;
}

LitheStatus lth_vtu_write(LitheCtx *ctx, const char *path, const LthVtu *vtu) {
  LitheStatus status = LITHE_OK;
  int n_blocks = 1 + vtu->n_point_arrays + vtu->n_cell_arrays;
  LthVtuBlock *blocks = NULL;
  LthVtuTopology *own = NULL;
  LTH_NEW_OR(done, ctx, blocks, n_blocks);
  if (!vtu->topology) LITHE_TRY_OR(done, lth_vtu_topology_create(ctx, vtu, &own));
  LITHE_TRY_OR(done, encode_fields(ctx, vtu, blocks));
  LITHE_TRY_OR(done, put_file(ctx, path, vtu, own ? own : vtu->topology, blocks, n_blocks));

done:
  for (int i = 0; blocks && i < n_blocks; i++) lth_vtu_block_free(ctx, blocks + i);
  lth_free(ctx, blocks);
  lth_vtu_topology_destroy(ctx, &own);
  return status;
}

LitheStatus lth_pvd_write(LitheCtx *ctx, const char *path, int n, const double *times,
                          const char *const *files) {
  LthFileWriter writer;
  LITHE_TRY(lth_file_open(ctx, path, &writer));
  fputs("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
        "byte_order=\"" BYTE_ORDER_NAME "\">\n  <Collection>\n",
        writer.stream);
  for (int i = 0; i < n; i++) {
    char time[LTH_NUMBER_TEXT_MAX];
    fprintf(writer.stream, "    <DataSet timestep=\"%s\" group=\"\" part=\"0\" file=\"",
            lth_number_text(times[i], time));
    put_escaped(writer.stream, files[i]);
    fputs("\"/>\n", writer.stream);
  }
  fputs("  </Collection>\n</VTKFile>\n", writer.stream);
  return lth_file_commit(ctx, &writer);
}
