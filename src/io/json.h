/// A small streaming JSON writer into memory, for result.json.
#pragma once

#include "base/ctx.h"

typedef struct LthJson LthJson;

LitheStatus lth_json_create(LitheCtx *ctx, LthJson **json);
void lth_json_destroy(LitheCtx *ctx, LthJson **json);

/// Structure and values. `key` is NULL inside arrays. Numbers are written with 17 digits where needed,
/// NaN and infinities as null. A failure (memory) is kept and returned by lth_json_text().
void lth_json_begin_object(LthJson *json, const char *key);
void lth_json_end_object(LthJson *json);
void lth_json_begin_array(LthJson *json, const char *key);
void lth_json_end_array(LthJson *json);
void lth_json_number(LthJson *json, const char *key, double value);
void lth_json_integer(LthJson *json, const char *key, LitheCount value);
void lth_json_string(LthJson *json, const char *key, const char *value);
void lth_json_bool(LthJson *json, const char *key, bool value);
void lth_json_vector(LthJson *json, const char *key, int n, const double *values);

/// The text so far, borrowed.
LitheStatus lth_json_text(LthJson *json, const char **text);
