/// Tags of a `.vtu` file: VTKFile, Piece, the sections with their DataArrays, AppendedData.
#include "io/vtu_head.h"

#include "io/xml_tag.h"

#include <string.h>

void lth_vtu_head_free(LitheCtx *ctx, LthVtuHead *head) {
  lth_free(ctx, head->arrays);
  lth_free(ctx, head->sections);
}

static LitheStatus read_file_tag(const LthText *text, const LthXmlTag *tag, LthVtuCoding *coding) {
  LthWord type = lth_xml_attribute(tag, "type"), order = lth_xml_attribute(tag, "byte_order");
  LthWord wide = lth_xml_attribute(tag, "header_type"), zip = lth_xml_attribute(tag, "compressor");
  if (!lth_word_is(type, "UnstructuredGrid"))
    return lth_text_fail(text, "the file holds a %.*s, expected an UnstructuredGrid",
                         type.length < 40 ? (int)type.length : 40, type.length ? type.at : "");
  coding->is_big = lth_word_is(order, "BigEndian");
  coding->has_wide_head = lth_word_is(wide, "UInt64");
  coding->is_compressed = zip.length > 0;
  if (zip.length > 0 && !lth_word_is(zip, "vtkZLibDataCompressor"))
    return lth_text_fail(text,
                         "the data are compressed by %.*s, expected vtkZLibDataCompressor or "
                         "none",
                         zip.length < 40 ? (int)zip.length : 40, zip.at);
  return LITHE_OK;
}

static LitheStatus read_count(const LthText *text, const LthXmlTag *tag, const char *key,
                              LitheCount *n) {
  if (!lth_word_integer(lth_xml_attribute(tag, key), n) || *n < 0 || *n > INT32_MAX / 3)
    return lth_text_fail(text, "%s of the piece is missing or out of range", key);
  return LITHE_OK;
}

static LitheStatus read_piece(const LthText *text, const LthXmlTag *tag, LthVtuHead *head) {
  LitheCount n_points = 0, n_cells = 0;
  LITHE_TRY(read_count(text, tag, "NumberOfPoints", &n_points));
  LITHE_TRY(read_count(text, tag, "NumberOfCells", &n_cells));
  if (n_cells == 0) return LITHE_OK;
  if (head->n_cells > 0)
    return lth_text_fail(text,
                         "the file has several pieces, expected one: merge them (in ParaView, "
                         "save with an ascending number of files set to one)");
  head->n_points = n_points;
  head->n_cells = n_cells;
  return LITHE_OK;
}

static LthVtuSection section_of(LthWord name) {
  static const char *const names[] = {"", "Points", "Cells", "PointData", "CellData"};
  for (int s = LTH_VTU_POINTS; s <= LTH_VTU_CELL_DATA; s++)
    if (lth_word_is(name, names[s])) return (LthVtuSection)s;
  return LTH_VTU_ELSEWHERE;
}

static LitheStatus read_array(LthText *text, const LthXmlTag *tag, LthVtuSection section,
                              LthVtuHead *head) {
  LthWord format = lth_xml_attribute(tag, "format"), type = lth_xml_attribute(tag, "type");
  LthVtuSource a = {.name = lth_xml_attribute(tag, "Name"),
                    .type = lth_vtu_type(type),
                    .components = 1,
                    .line = text->line};
  LitheCount components = 1;
  if (lth_word_integer(lth_xml_attribute(tag, "NumberOfComponents"), &components) &&
      components > 0 && components < 1000)
    a.components = (LitheIndex)components;
  // strings and the like have no part in a mesh
  if (a.type == LTH_VTU_TYPES) return LITHE_OK;
  a.format = lth_word_is(format, "appended") ? LTH_VTU_APPENDED
             : lth_word_is(format, "binary") ? LTH_VTU_BINARY
                                             : LTH_VTU_ASCII;
  if (a.format == LTH_VTU_APPENDED &&
      !lth_word_integer(lth_xml_attribute(tag, "offset"), &a.offset))
    return lth_vtu_array_fail(&head->coding, &a, "it has no offset into the appended data");
  const char *close = memchr(tag->content, '<', (size_t)(text->end - tag->content));
  a.content = (LthWord){tag->content, (size_t)((close ? close : text->end) - tag->content)};
  LTH_RESERVE(text->ctx, head->arrays, head->cap_arrays, head->n_arrays + 1);
  LTH_RESERVE(text->ctx, head->sections, head->cap_sections, head->n_arrays + 1);
  head->arrays[head->n_arrays] = a;
  head->sections[head->n_arrays++] = section;
  return LITHE_OK;
}

static LitheStatus read_appended(const LthText *text, const LthXmlTag *tag, LthVtuCoding *coding) {
  const char *mark = memchr(tag->content, '_', (size_t)(text->end - tag->content));
  if (!mark) return lth_text_fail(text, "the appended data do not begin with an underscore");
  coding->appended = mark + 1;
  coding->appended_end = text->end;
  coding->appended_is_base64 = lth_word_is(lth_xml_attribute(tag, "encoding"), "base64");
  return LITHE_OK;
}

LitheStatus lth_vtu_head_parse(LitheCtx *ctx, const char *name, const char *data, size_t size,
                               LthVtuHead *head) {
  LthText text = lth_text(ctx, name, data, size);
  LthXmlTag tag;
  LthVtuSection section = LTH_VTU_ELSEWHERE;
  bool has_file = false;
  head->coding.ctx = ctx;
  head->coding.file = name;
  while (!head->coding.appended && lth_xml_next(&text, &tag)) {
    if (lth_word_is(tag.name, "VTKFile") && !tag.is_end) {
      LITHE_TRY(read_file_tag(&text, &tag, &head->coding));
      has_file = true;
    } else if (section_of(tag.name) != LTH_VTU_ELSEWHERE) {
      section = tag.is_end ? LTH_VTU_ELSEWHERE : section_of(tag.name);
    } else if (lth_word_is(tag.name, "Piece") && !tag.is_end) {
      LITHE_TRY(read_piece(&text, &tag, head));
    } else if (lth_word_is(tag.name, "DataArray") && !tag.is_end && section != LTH_VTU_ELSEWHERE) {
      LITHE_TRY(read_array(&text, &tag, section, head));
    } else if (lth_word_is(tag.name, "AppendedData") && !tag.is_end) {
      LITHE_TRY(read_appended(&text, &tag, &head->coding));
    }
  }
  if (!has_file) return lth_text_fail(&text, "the file has no tag VTKFile, expected a .vtu file");
  return LITHE_OK;
}

const LthVtuSource *lth_vtu_find(const LthVtuHead *head, LthVtuSection section, const char *name) {
  for (LitheIndex i = 0; i < head->n_arrays; i++)
    if (head->sections[i] == section && (!name || lth_word_is(head->arrays[i].name, name)))
      return &head->arrays[i];
  return NULL;
}
