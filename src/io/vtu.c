/// VTU files of polyhedral fields (compressed appended data) and the PVD collection.
///
/// Written as https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html lays down: an XML head
/// whose DataArrays carry offsets into one appended, raw, zlib-compressed section.
#include "io/vtu.h"

#include "io/file.h"
#include "io/number_text.h"
#include "io/vtu_topology.h"
#include "io/xml_tag.h"

#include <stdio.h>

static void put_cells(FILE *out, const LthVtuTopology *topology, LitheCount *offset) {
  static const char *const names[LTH_VTU_TOPOLOGY_ARRAYS] = {"connectivity", "offsets", "types",
                                                             "faces", "faceoffsets"};
  fputs("      <Cells>\n", out);
  for (int i = 0; i < LTH_VTU_TOPOLOGY_ARRAYS; i++)
    lth_vtk_put_array(out, i == 2 ? "UInt8" : "Int64", names[i], 1, topology->block + i, offset);
  fputs("      </Cells>\n", out);
}

/// `blocks` holds the points, then the point arrays, then the cell arrays: the order of the file.
static void put_head(FILE *out, const LthVtu *vtu, const LthVtuTopology *topology,
                     const LthVtuBlock *blocks) {
  LitheCount offset = 0;
  lth_vtk_put_opening(out, "UnstructuredGrid");
  fputs("  <UnstructuredGrid>\n", out);
  lth_vtk_put_time(out, vtu->time);
  fprintf(out, "    <Piece NumberOfPoints=\"%d\" NumberOfCells=\"%d\">\n", vtu->n_points,
          vtu->mesh->n_cells);
  fputs("      <Points>\n", out);
  lth_vtk_put_array(out, vtu->wide_points ? "Float64" : "Float32", "Points", 3, blocks, &offset);
  fputs("      </Points>\n", out);
  lth_vtk_put_arrays(out, "PointData", vtu->n_point_arrays, vtu->point_arrays, blocks + 1, &offset);
  lth_vtk_put_arrays(out, "CellData", vtu->n_cell_arrays, vtu->cell_arrays,
                     blocks + 1 + vtu->n_point_arrays, &offset);
  put_cells(out, topology, &offset);
  fputs("    </Piece>\n  </UnstructuredGrid>\n", out);
  lth_vtk_put_appended(out);
}

static LitheStatus put_file(LitheCtx *ctx, const char *path, const LthVtu *vtu,
                            const LthVtuTopology *topology, const LthVtuBlock *blocks,
                            int n_blocks) {
  LthFileWriter writer;
  LITHE_TRY(lth_file_open(ctx, path, &writer));
  put_head(writer.stream, vtu, topology, blocks);
  for (int i = 0; i < n_blocks; i++) lth_vtk_put_block(writer.stream, blocks + i);
  for (int i = 0; i < LTH_VTU_TOPOLOGY_ARRAYS; i++)
    lth_vtk_put_block(writer.stream, topology->block + i);
  lth_vtk_put_end(writer.stream);
  return lth_file_commit(ctx, &writer);
}

static LitheStatus encode_fields(LitheCtx *ctx, const LthVtu *vtu, LthVtuBlock *blocks) {
  if (vtu->wide_points)
    LITHE_TRY(lth_vtu_block_encode(ctx, vtu->points,
                                   3 * (LitheCount)sizeof *vtu->points * vtu->n_points, blocks++));
  else
    LITHE_TRY(lth_vtk_encode_rows(ctx, vtu->n_points, 3, vtu->points, blocks++));
  for (int i = 0; i < vtu->n_point_arrays; i++) {
    const LthVtuArray *a = vtu->point_arrays + i;
    LITHE_TRY(lth_vtk_encode_rows(ctx, vtu->n_points, a->components, a->data, blocks++));
  }
  for (int i = 0; i < vtu->n_cell_arrays; i++) {
    const LthVtuArray *a = vtu->cell_arrays + i;
    LITHE_TRY(lth_vtk_encode_rows(ctx, vtu->mesh->n_cells, a->components, a->data, blocks++));
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
        "byte_order=\"" LTH_VTK_BYTE_ORDER "\">\n  <Collection>\n",
        writer.stream);
  for (int i = 0; i < n; i++) {
    char time[LTH_NUMBER_TEXT_MAX];
    fprintf(writer.stream, "    <DataSet timestep=\"%s\" group=\"\" part=\"0\" file=\"",
            lth_number_text(times[i], time));
    lth_xml_put_text(writer.stream, files[i]);
    fputs("\"/>\n", writer.stream);
  }
  fputs("  </Collection>\n</VTKFile>\n", writer.stream);
  return lth_file_commit(ctx, &writer);
}
