/// A small streaming JSON writer into memory, for result.json.
#include "io/json.h"

#include "io/number_text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define DEPTH_MAX 32

struct LthJson {
  LitheCtx *ctx;
  LitheStatus status; ///< first failure; later calls do nothing
  char *text;
  LitheCount length, cap;
  int depth;
  bool has_member[DEPTH_MAX + 1];
};

LitheStatus lth_json_create(LitheCtx *ctx, LthJson **json) {
  LTH_NEW(ctx, *json, 1);
  (*json)->ctx = ctx;
  return LITHE_OK;
}

void lth_json_destroy(LitheCtx *ctx, LthJson **json) {
  if (!*json) return;
  lth_free(ctx, (*json)->text);
  lth_free(ctx, *json);
  *json = NULL;
}

static void put(LthJson *json, const char *bytes, size_t n) {
  if (json->status != LITHE_OK) return;
  json->status = lth_reserve_(json->ctx, (void **)&json->text, &json->cap,
                              json->length + (LitheCount)n + 1, 1);
  if (json->status != LITHE_OK) return;
  memcpy(json->text + json->length, bytes, n);
  json->length += (LitheCount)n;
  json->text[json->length] = 0;
}

static void put_text(LthJson *json, const char *text) { put(json, text, strlen(text)); }

static void put_newline(LthJson *json) {
  put_text(json, "\n");
  for (int i = 0; i < json->depth; i++) put_text(json, "  ");
}

/// A string in quotes; control characters, quotes and backslashes escaped, UTF-8 passed through.
static void put_quoted(LthJson *json, const char *text) {
  put_text(json, "\"");
  for (const char *c = text ? text : ""; *c; c++) {
    char escape[8];
    if (*c == '"' || *c == '\\') {
      snprintf(escape, sizeof escape, "\\%c", *c);
      put_text(json, escape);
    } else if ((unsigned char)*c < 0x20) {
      snprintf(escape, sizeof escape, "\\u%04x", (unsigned)*c);
      put_text(json, escape);
    } else {
      put(json, c, 1);
    }
  }
  put_text(json, "\"");
}

/// Comma, line break and key in front of a value.
static void begin_member(LthJson *json, const char *key) {
  if (json->has_member[json->depth]) put_text(json, ",");
  json->has_member[json->depth] = true;
  if (json->depth > 0) put_newline(json);
  if (!key) return;
  put_quoted(json, key);
  put_text(json, ": ");
}

static void open_level(LthJson *json, const char *key, const char *bracket) {
  begin_member(json, key);
  put_text(json, bracket);
  LITHE_ASSERT(json->depth < DEPTH_MAX);
  json->has_member[++json->depth] = false;
}

static void close_level(LthJson *json, const char *bracket) {
  LITHE_ASSERT(json->depth > 0);
  bool is_empty = !json->has_member[json->depth--];
  if (!is_empty) put_newline(json);
  put_text(json, bracket);
  if (json->depth == 0) put_text(json, "\n");
}

void lth_json_begin_object(LthJson *json, const char *key) { open_level(json, key, "{"); }
void lth_json_end_object(LthJson *json) { close_level(json, "}"); }
void lth_json_begin_array(LthJson *json, const char *key) { open_level(json, key, "["); }
void lth_json_end_array(LthJson *json) { close_level(json, "]"); }

static void put_number(LthJson *json, double value) {
  char text[LTH_NUMBER_TEXT_MAX];
  put_text(json, isfinite(value) ? lth_number_text(value, text) : "null");
}

void lth_json_number(LthJson *json, const char *key, double value) {
  begin_member(json, key);
  put_number(json, value);
}

void lth_json_integer(LthJson *json, const char *key, LitheCount value) {
  char text[LTH_NUMBER_TEXT_MAX];
  snprintf(text, sizeof text, "%lld", (long long)value);
  begin_member(json, key);
  put_text(json, text);
}

void lth_json_string(LthJson *json, const char *key, const char *value) {
  begin_member(json, key);
  put_quoted(json, value);
}

void lth_json_bool(LthJson *json, const char *key, bool value) {
  begin_member(json, key);
  put_text(json, value ? "true" : "false");
}

void lth_json_vector(LthJson *json, const char *key, int n, const double *values) {
  begin_member(json, key);
  put_text(json, "[");
  for (int i = 0; i < n; i++) {
    if (i > 0) put_text(json, ", ");
    put_number(json, values[i]);
  }
  put_text(json, "]");
}

LitheStatus lth_json_text(LthJson *json, const char **text) {
  *text = json->text ? json->text : "";
  return json->status;
}
