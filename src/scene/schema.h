/// The scene file's schema (schema/scene.schema.json), checked against a document.
///
/// It is JSON Schema 2020-12; the reader understands type, properties, required, additionalProperties
/// (always false), items, minItems, maxItems, enum, const, minimum, maximum, exclusiveMinimum,
/// exclusiveMaximum, minLength, default, anyOf (alternatives told apart by their kind), oneOf and `not`
/// of `required` lists, $ref into $defs, and these of its own:
///   x-unit          SI unit of a number; it may be written with any unit of that dimension
///   x-unit-by       {key, units}: the unit is that of the word which the neighbouring key has
///   x-varies        "xyz", "xyzt", "t": an expression of these may stand for the number
///   x-built         false: known, but refused in this version
///   x-unbuilt       the words of an enum that are refused in this version
///   x-built-maximum the largest number, or the longest list, that this version takes
///   x-plane         a list with an entry a dimension: what stands third in a scene of dimension 2
///   x-plane-title   its title there
///   x-dimensions    2 or 3: a key of scenes of that dimension alone
#pragma once

#include "scene/quantity.h"

typedef struct LthSchema {
  LitheCtx *ctx;
  LthReport *report;
  LthExpressionList *expressions;
  const LthNode *root;
  int dimension; ///< of the document that is checked
} LthSchema;

/// Parse the schema that was built into the library. It lives in the report's arena.
LitheStatus lth_schema_create(LitheCtx *ctx, LthReport *report, LthExpressionList *expressions,
                              LthSchema *schema);

/// Check a document: errors go into the report; missing keys that have a default get it, numbers get
/// their values, and where `dimension` is 2 vectors get their third entry. A failure is memory only.
LitheStatus lth_schema_check(LthSchema *schema, LthNode *document);

/// Is this a key of scenes of the document's dimension?
bool lth_schema_has_dimension(const LthSchema *schema, const LthNode *property);

/// A keyword of a schema node, also through its $ref; NULL where it is not given.
const LthNode *lth_schema_keyword(const LthSchema *schema, const LthNode *node, const char *name);

/// What a schema node expects, in words: "a number > 0 [Pa]". In the arena, never NULL.
const char *lth_schema_describe(const LthSchema *schema, const LthNode *node);

/// True where `list` (of scalars, may be NULL) holds `text`.
bool lth_schema_lists(const LthNode *list, const char *text);

/// Number of a keyword, `otherwise` where it is not given.
double lth_schema_number(const LthSchema *schema, const LthNode *node, const char *name,
                         double otherwise);

/// The words of an enum that this version takes, as "a, b or c".
const char *lth_schema_words(const LthSchema *schema, const LthNode *node);
