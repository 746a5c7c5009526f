/// A pool of compiled copies: muParser evaluates one expression on one thread at a time, so a thread
/// takes a free copy, beginning with the one of its own number.
#include "scene/expression.h"

#include "scene/report.h"

#include <ctype.h>
#include <math.h>
#include <muParserDLL.h>
#include <omp.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#define COPIES_MAX 16
#define LENGTH_MAX 4000
#define PI 3.14159265358979323846

typedef struct Copy {
  _Alignas(64) atomic_flag busy;
  bool has_gap;
  muParserHandle_t parser;
  double variables[6];
  LthExpressionGap gap;
} Copy;

struct LthExpression {
  int n_copies, uses;
  double scale;
  const LthImage *image; ///< or NULL
  char *text;
  Copy copies[];
};

static const char *const variable_names[6] = {"x", "y", "z", "t", "value", "label"};

/// muParser prints nothing where a handler is set; what happened is asked for afterwards.
static void ignore_error(muParserHandle_t parser) { (void)parser; }

static muParserHandle_t new_parser(const char *text, double variables[6]) {
  muParserHandle_t parser = mupCreate(muBASETYPE_FLOAT);
  if (!parser) return NULL;
  mupSetErrorHandler(parser, ignore_error);
  mupClearConst(parser);
  mupDefineConst(parser, "pi", PI);
  for (int i = 0; i < 6; i++) mupDefineVar(parser, variable_names[i], &variables[i]);
  mupSetExpr(parser, text);
  return parser;
}

static LitheStatus fail_at(LthExpressionError *error, int column, const char *format, ...) {
  va_list args;
  va_start(args, format);
  // NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): clang 14 loses va_start when it inlines
  vsnprintf(error->text, sizeof error->text, format, args);
  va_end(args);
  error->column = column;
  return LITHE_BAD_INPUT;
}

/// What muParser would take but a scene does not mean: assignments, texts, several values.
static LitheStatus check_characters(const char *text, LthExpressionError *error) {
  int depth = 0;
  for (const char *c = text; *c; c++) {
    int column = (int)(c - text) + 1;
    if (*c == '"' || *c == '\'') return fail_at(error, column, "a quote inside the expression");
    if ((unsigned char)*c >= 0x80)
      return fail_at(error, column, "a character that no expression has");
    if (strchr("=!<>", *c) && c[1] == '=') {
      c++;
    } else if (*c == '=') {
      return fail_at(error, column, "an assignment (=); == compares");
    }
    if (*c == '(') depth++;
    if (*c == ')') depth--;
    if (depth > 100) return fail_at(error, column, "too many brackets in each other");
    if (*c == ',' && depth == 0)
      return fail_at(error, column,
                     "a comma outside a function's brackets (decimals take a point)");
  }
  return LITHE_OK;
}

static const char *nearest_name(const char *token) {
  static const char *const known[] = {
      "x",    "y",    "z",    "t",     "pi",    "sin",   "cos",   "tan", "asin", "acos", "atan",
      "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "atan2", "exp", "log",  "log2", "log10",
      "ln",   "sqrt", "abs",  "sign",  "rint",  "min",   "max",   "sum", "avg"};
  return lth_nearest_word(token, known, sizeof known / sizeof *known);
}

static LitheStatus explain_unknown(const char *token, int column, LthExpressionError *error) {
  char word[40] = "";
  size_t n = strspn(token, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789.");
  if (n == 0) n = strcspn(token, " ");
  if (n >= sizeof word) n = sizeof word - 1;
  memcpy(word, token, n);
  const char *nearest = nearest_name(word);
  const char *meant = nearest ? ", did you mean " : "";
  if (isdigit((unsigned char)word[0]))
    return fail_at(error, column, "\"%s\" is no number of double precision", word);
  if (isalpha((unsigned char)word[0]))
    return fail_at(error, column, "unknown name \"%s\"%s%s", word, meant, nearest ? nearest : "");
  return fail_at(error, column, "unexpected \"%s\"", word);
}

/// muParser's error codes (muParserError.h) in our words.
static LitheStatus explain(muParserHandle_t parser, const char *text, LthExpressionError *error) {
  int code = mupGetErrorCode(parser), column = mupGetErrorPos(parser) + 1;
  int length = (int)strlen(text);
  const char *token = mupGetErrorToken(parser);
  if (column < 1 || column > length + 1) column = length + 1;
  switch (code) {
  case 1:
    return explain_unknown(token, column, error);
  case 2:
    return fail_at(error, length + 1, "it ends too early");
  case 7:
    return fail_at(error, column, "unexpected bracket \"%.20s\"", token);
  case 11:
    return fail_at(error, length + 1, "a closing bracket is missing");
  case 14:
    return fail_at(error, column, "too many arguments for %.30s()", token);
  case 15:
    return fail_at(error, column, "too few arguments for %.30s()", token);
  case 25:
    return fail_at(error, 1, "it is empty");
  case 33:
    return fail_at(error, length + 1, "the \":\" of a choice ? : is missing");
  default:
    if (token[0]) return fail_at(error, column, "unexpected \"%.30s\"", token);
    return fail_at(error, column, "it cannot be understood");
  }
}

static int count_copies(const LitheCtx *ctx) {
  int n = lth_threads(ctx) > omp_get_max_threads() ? lth_threads(ctx) : omp_get_max_threads();
  return n < 1 ? 1 : n < COPIES_MAX ? n : COPIES_MAX;
}

static int find_uses(muParserHandle_t parser) {
  int uses = 0, n = mupGetExprVarNum(parser);
  for (int i = 0; i < n; i++) {
    const char *name = NULL;
    double *place = NULL;
    mupGetExprVar(parser, (unsigned)i, &name, &place);
    for (int k = 0; k < 6; k++)
      if (name && strcmp(name, variable_names[k]) == 0) uses |= 1 << k;
  }
  return uses;
}

/// Evaluating once compiles to bytecode, so that later calls only run it.
static LitheStatus compile(LthExpression *e, Copy *copy, LthExpressionError *error) {
  int n_values = 0;
  mupEvalMulti(copy->parser, &n_values);
  if (mupError(copy->parser)) return explain(copy->parser, e->text, error);
  if (n_values != 1) return fail_at(error, 1, "it has %d values", n_values);
  mupEval(copy->parser);
  return LITHE_OK;
}

LitheStatus lth_expression_create(LitheCtx *ctx, const char *text, size_t length,
                                  LthExpressionError *error, LthExpression **expression) {
  LitheStatus status = LITHE_OK;
  LthExpression *e = NULL;
  *expression = NULL;
  *error = (LthExpressionError){0};
  if (length > LENGTH_MAX)
    return fail_at(error, LENGTH_MAX, "it is longer than %d letters", LENGTH_MAX);
  int n_copies = count_copies(ctx);
  LITHE_TRY(lth_new_(ctx, (void **)&e, 1, sizeof *e + (size_t)n_copies * sizeof(Copy)));
  e->scale = 1;
  LTH_NEW_OR(done, ctx, e->text, (LitheCount)length + 1);
  memcpy(e->text, text, length);
  LITHE_TRY_OR(done, check_characters(e->text, error));
  for (int i = 0; i < n_copies; i++) {
    Copy *copy = &e->copies[i];
    copy->parser = new_parser(e->text, copy->variables);
    if (!copy->parser) status = lth_fail(ctx, LITHE_NO_MEMORY, "out of memory for an expression");
    if (status != LITHE_OK) goto done;
    e->n_copies = i + 1;
    atomic_flag_clear(&copy->busy);
    LITHE_TRY_OR(done, compile(e, copy, error));
  }
  e->uses = find_uses(e->copies[0].parser);

done:
  if (status != LITHE_OK) lth_expression_destroy(ctx, &e);
  *expression = e;
  return status;
}

void lth_expression_destroy(LitheCtx *ctx, LthExpression **expression) {
  LthExpression *e = *expression;
  if (!e) return;
  for (int i = 0; i < e->n_copies; i++) mupRelease(e->copies[i].parser);
  lth_free(ctx, e->text);
  lth_free(ctx, e);
  *expression = NULL;
}

int lth_expression_uses(const LthExpression *expression) { return expression->uses; }

void lth_expression_bind(LthExpression *expression, const LthImage *image) {
  expression->image = image;
}

void lth_expression_scale(LthExpression *expression, double factor) { expression->scale *= factor; }

/// A copy nobody else uses now.
static Copy *take_copy(LthExpression *e) {
  for (int i = omp_get_thread_num();; i++) {
    Copy *copy = &e->copies[i % e->n_copies];
    if (!atomic_flag_test_and_set_explicit(&copy->busy, memory_order_acquire)) return copy;
  }
}

/// By time, then by place.
static bool is_earlier(const LthExpressionGap *a, const LthExpressionGap *b) {
  if (a->t != b->t) return a->t < b->t;
  for (int i = 0; i < 3; i++)
    if (a->x[i] != b->x[i]) return a->x[i] < b->x[i];
  return false;
}

static void note_gap(Copy *copy, double value) {
  const double *v = copy->variables;
  LthExpressionGap gap = {.x = {v[0], v[1], v[2]}, .t = v[3], .value = value};
  if (!copy->has_gap || is_earlier(&gap, &copy->gap)) copy->gap = gap;
  copy->has_gap = true;
}

bool lth_expression_gap(const LthExpression *e, LthExpressionGap *gap) {
  bool has_gap = false;
  for (int i = 0; i < e->n_copies; i++) {
    const Copy *copy = &e->copies[i];
    if (!copy->has_gap || (has_gap && !is_earlier(&copy->gap, gap))) continue;
    *gap = copy->gap;
    has_gap = true;
  }
  return has_gap;
}

double lth_expression_eval(const void *self, const double x[3], double t) {
  LthExpression *e = (LthExpression *)self; // the pool inside is guarded by its flags
  Copy *copy = take_copy(e);
  memcpy(copy->variables, x, 3 * sizeof *x);
  copy->variables[3] = t;
  if (e->image && e->uses & LTH_USES_VALUE)
    copy->variables[4] = lth_volume_value(e->image->volume, x);
  if (e->image && e->uses & LTH_USES_LABEL) copy->variables[5] = lth_image_label(e->image, x);
  double value = mupEval(copy->parser) * e->scale;
  if (!isfinite(value)) note_gap(copy, value);
  atomic_flag_clear_explicit(&copy->busy, memory_order_release);
  return value;
}
