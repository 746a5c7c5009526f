/// Decoding of DataArrays.
///
/// A block of binary values is preceded by its length in bytes, or where it is compressed by: number of blocks,
/// bytes of a full block, bytes of the last block where it is not full (else 0), compressed bytes of each.
#include "io/vtu_array.h"

#include "io/bytes.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <zlib.h>

/// zlib cannot make more of a byte than this.
#define INFLATE_MAX 1040

static const struct {
  const char *name;
  int bytes;
} types[LTH_VTU_TYPES] = {{"Int8", 1},    {"UInt8", 1},  {"Int16", 2}, {"UInt16", 2},
                          {"Int32", 4},   {"UInt32", 4}, {"Int64", 8}, {"UInt64", 8},
                          {"Float32", 4}, {"Float64", 8}};

LthVtuType lth_vtu_type(LthWord name) {
  for (int t = 0; t < LTH_VTU_TYPES; t++)
    if (lth_word_is(name, types[t].name)) return (LthVtuType)t;
  return LTH_VTU_TYPES;
}

LitheStatus lth_vtu_array_fail(const LthVtuCoding *coding, const LthVtuSource *source,
                               const char *format, ...) {
  char message[512];
  va_list args;
  va_start(args, format);
  vsnprintf(message, sizeof message, format, args);
  va_end(args);
  LITHE_FAIL(coding->ctx, LITHE_BAD_INPUT, "%s:%lld: array %.*s: %s", coding->file,
             (long long)source->line, source->name.length < 80 ? (int)source->name.length : 80,
             source->name.length > 0 ? source->name.at : "", message);
}

/// Bytes of a file, plain or from base64. Padding may stand where one encoded part ends and the next begins.
typedef struct Stream {
  const char *at, *end;
  bool is_base64;
  unsigned char kept[3]; ///< decoded and not yet taken
  int n_kept;
} Stream;

static int base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/// Decode the next four characters into 1 to 3 bytes; false at the end of the encoding.
static bool refill(Stream *s) {
  uint32_t bits = 0;
  int n = 0, n_pad = 0;
  while (n < 4) {
    while (s->at < s->end && (*s->at == ' ' || *s->at == '\n' || *s->at == '\r' || *s->at == '\t'))
      s->at++;
    if (s->at == s->end) return false;
    int value = base64_value(*s->at);
    if (value < 0 && *s->at != '=') return false;
    if (value < 0) n_pad++;
    bits = bits << 6 | (uint32_t)(value < 0 ? 0 : value);
    s->at++;
    n++;
  }
  s->n_kept = n_pad > 2 ? 0 : 3 - n_pad;
  for (int i = 0; i < 3; i++) s->kept[i] = (unsigned char)(bits >> (16 - 8 * i));
  return s->n_kept > 0;
}

/// Take n bytes; false where the stream ends before.
static bool take(Stream *s, LitheCount n, unsigned char *to) {
  if (!s->is_base64) {
    if (s->end - s->at < n) return false;
    memcpy(to, s->at, (size_t)n);
    s->at += n;
    return true;
  }
  while (n > 0) {
    if (s->n_kept == 0 && !refill(s)) return false;
    *to++ = s->kept[0];
    memmove(s->kept, s->kept + 1, 2);
    s->n_kept--;
    n--;
  }
  return true;
}

/// Bytes that can still come at most.
static LitheCount bytes_left(const Stream *s) {
  LitheCount n = s->end - s->at;
  return s->is_base64 ? n / 4 * 3 + s->n_kept : n;
}

static LitheStatus cut_short(const LthVtuCoding *c, const LthVtuSource *a) {
  return lth_vtu_array_fail(c, a,
                            "its data end too early: the file is cut short or not what its "
                            "head says");
}

static LitheStatus open_stream(const LthVtuCoding *c, const LthVtuSource *a, Stream *s) {
  *s = (Stream){.at = a->content.at, .end = a->content.at + a->content.length, .is_base64 = true};
  if (a->format != LTH_VTU_APPENDED) return LITHE_OK;
  if (!c->appended) return lth_vtu_array_fail(c, a, "the file has no appended data");
  if (a->offset < 0 || a->offset > c->appended_end - c->appended)
    return lth_vtu_array_fail(c, a,
                              "its offset %lld lies behind the end of the file: it is cut short",
                              (long long)a->offset);
  *s = (Stream){
      .at = c->appended + a->offset, .end = c->appended_end, .is_base64 = c->appended_is_base64};
  return LITHE_OK;
}

static LitheStatus take_head(const LthVtuCoding *c, const LthVtuSource *a, Stream *s,
                             LitheCount *value) {
  unsigned char bytes[8];
  int n = c->has_wide_head ? 8 : 4;
  if (!take(s, n, bytes)) return cut_short(c, a);
  uint64_t raw = lth_bytes_unsigned((const char *)bytes, n, c->is_big);
  if (raw > INT64_MAX / 2) return cut_short(c, a);
  *value = (LitheCount)raw;
  return LITHE_OK;
}

static LitheStatus read_plain(const LthVtuCoding *c, const LthVtuSource *a, Stream *s,
                              unsigned char **bytes, LitheCount *size) {
  LITHE_TRY(take_head(c, a, s, size));
  if (*size > bytes_left(s)) return cut_short(c, a);
  LTH_NEW(c->ctx, *bytes, *size);
  return take(s, *size, *bytes) ? LITHE_OK : cut_short(c, a);
}

/// Uncompress `n` blocks of the compressed sizes given, one after the other.
static LitheStatus inflate_blocks(const LthVtuCoding *c, const LthVtuSource *a, Stream *s,
                                  LitheCount n, LitheCount full, LitheCount last,
                                  const LitheCount *packed, unsigned char *to) {
  LitheStatus status = LITHE_OK;
  unsigned char *block = NULL;
  LitheCount most = 0;
  for (LitheCount i = 0; i < n; i++) most = packed[i] > most ? packed[i] : most;
  LTH_NEW(c->ctx, block, most);
  for (LitheCount i = 0; i < n && status == LITHE_OK; i++) {
    uLongf length = (uLongf)(i + 1 < n ? full : last), want = length;
    if (!take(s, packed[i], block))
      status = cut_short(c, a);
    else if (uncompress(to, &length, block, (uLong)packed[i]) != Z_OK || length != want)
      status =
          lth_vtu_array_fail(c, a, "block %lld of its compressed data is damaged", (long long)i);
    to += want;
  }
  lth_free(c->ctx, block);
  return status;
}

static LitheStatus read_packed(const LthVtuCoding *c, const LthVtuSource *a, Stream *s,
                               unsigned char **bytes, LitheCount *size) {
  LitheStatus status = LITHE_OK;
  LitheCount n = 0, full = 0, last = 0, *packed = NULL, total = 0;
  LITHE_TRY(take_head(c, a, s, &n));
  LITHE_TRY(take_head(c, a, s, &full));
  LITHE_TRY(take_head(c, a, s, &last));
  if (last == 0) last = full;
  if (n > bytes_left(s) / (c->has_wide_head ? 8 : 4) || full > INT32_MAX || last > full)
    return cut_short(c, a);
  LTH_NEW(c->ctx, packed, n);
  for (LitheCount i = 0; i < n; i++) {
    LITHE_TRY_OR(done, take_head(c, a, s, &packed[i]));
    LitheCount whole = i + 1 < n ? full : last;
    total += packed[i];
    if (total > bytes_left(s) + 8 || whole > INFLATE_MAX * (packed[i] + 1))
      LITHE_TRY_OR(done, cut_short(c, a));
  }
  *size = n == 0 ? 0 : (n - 1) * full + last;
  LTH_NEW_OR(done, c->ctx, *bytes, *size);
  LITHE_TRY_OR(done, inflate_blocks(c, a, s, n, full, last, packed, *bytes));
done:
  lth_free(c->ctx, packed);
  return status;
}

/// The bytes of a binary array.
static LitheStatus read_bytes(const LthVtuCoding *c, const LthVtuSource *a, unsigned char **bytes,
                              LitheCount *n) {
  Stream s;
  LitheCount size = 0;
  LITHE_TRY(open_stream(c, a, &s));
  LITHE_TRY(c->is_compressed ? read_packed(c, a, &s, bytes, &size)
                             : read_plain(c, a, &s, bytes, &size));
  if (size % types[a->type].bytes != 0)
    return lth_vtu_array_fail(c, a, "it has %lld bytes, which is no whole number of %s",
                              (long long)size, types[a->type].name);
  *n = size / types[a->type].bytes;
  return LITHE_OK;
}

static int64_t integer_at(const unsigned char *bytes, LthVtuType type, bool is_big) {
  uint64_t raw = lth_bytes_unsigned((const char *)bytes, types[type].bytes, is_big);
  switch (type) {
  case LTH_VTU_INT8:
    return (int8_t)raw;
  case LTH_VTU_INT16:
    return (int16_t)raw;
  case LTH_VTU_INT32:
    return (int32_t)raw;
  default:
    return (int64_t)raw;
  }
}

static double double_at(const unsigned char *bytes, LthVtuType type, bool is_big) {
  if (type == LTH_VTU_FLOAT32) return (double)lth_bytes_f32((const char *)bytes, is_big);
  if (type == LTH_VTU_FLOAT64) return lth_bytes_f64((const char *)bytes, is_big);
  return (double)integer_at(bytes, type, is_big);
}

/// A whole number that a double holds exactly, or nothing that an index could be.
static int64_t whole(double value) {
  return fabs(value) < 0x1p53 && value == floor(value) ? (int64_t)value : INT64_MIN;
}

static LitheStatus read_words(const LthVtuCoding *c, const LthVtuSource *a, double **doubles,
                              int64_t **integers, LitheCount *n) {
  LthText text = lth_text(c->ctx, c->file, a->content.at, a->content.length);
  LthWord word;
  LitheCount cap = 0;
  text.line = a->line;
  for (*n = 0; lth_text_word_across(&text, &word); ++*n) {
    double value = 0;
    LitheCount integer = 0;
    bool is_integer = integers && lth_word_integer(word, &integer);
    if (!is_integer && !lth_word_number(word, &value))
      return lth_vtu_array_fail(c, a, "'%.*s' in line %lld, expected a number",
                                word.length < 40 ? (int)word.length : 40, word.at,
                                (long long)text.line);
    if (doubles) {
      LTH_RESERVE(c->ctx, *doubles, cap, *n + 1);
      (*doubles)[*n] = value;
    } else {
      LTH_RESERVE(c->ctx, *integers, cap, *n + 1);
      (*integers)[*n] = is_integer ? integer : whole(value);
    }
  }
  return LITHE_OK;
}

LitheStatus lth_vtu_read_doubles(const LthVtuCoding *c, const LthVtuSource *a, double **values,
                                 LitheCount *n) {
  unsigned char *bytes = NULL;
  int width = types[a->type].bytes;
  *values = NULL;
  if (a->format == LTH_VTU_ASCII) return read_words(c, a, values, NULL, n);
  LitheStatus status = read_bytes(c, a, &bytes, n);
  if (status == LITHE_OK) status = lth_new_(c->ctx, (void **)values, *n, sizeof **values);
  for (LitheCount i = 0; status == LITHE_OK && i < *n; i++)
    (*values)[i] = double_at(bytes + i * width, a->type, c->is_big);
  lth_free(c->ctx, bytes);
  return status;
}

LitheStatus lth_vtu_read_integers(const LthVtuCoding *c, const LthVtuSource *a, int64_t **values,
                                  LitheCount *n) {
  unsigned char *bytes = NULL;
  int width = types[a->type].bytes;
  bool is_float = a->type == LTH_VTU_FLOAT32 || a->type == LTH_VTU_FLOAT64;
  *values = NULL;
  if (a->format == LTH_VTU_ASCII) return read_words(c, a, NULL, values, n);
  LitheStatus status = read_bytes(c, a, &bytes, n);
  if (status == LITHE_OK) status = lth_new_(c->ctx, (void **)values, *n, sizeof **values);
  for (LitheCount i = 0; status == LITHE_OK && i < *n; i++)
    (*values)[i] = is_float ? whole(double_at(bytes + i * width, a->type, c->is_big))
                            : integer_at(bytes + i * width, a->type, c->is_big);
  lth_free(c->ctx, bytes);
  return status;
}
