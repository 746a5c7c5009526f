/// A tag reader for the heads of VTK's XML files.
#define _GNU_SOURCE // memmem
#include "io/xml_tag.h"

#include <ctype.h>
#include <string.h>

const char *lth_xml_entity(char letter) {
  switch (letter) {
  case '<':
    return "&lt;";
  case '>':
    return "&gt;";
  case '&':
    return "&amp;";
  case '"':
    return "&quot;";
  default:
    return NULL;
  }
}

void lth_xml_put_text(FILE *out, const char *text) {
  for (; *text; text++) {
    const char *entity = lth_xml_entity(*text);
    if (entity)
      fputs(entity, out);
    else
      fputc(*text, out);
  }
}

static void move_to(LthText *text, const char *at) {
  for (; text->at < at; text->at++) text->line += *text->at == '\n';
}

/// Behind the next occurrence of `mark`, or the end.
static const char *behind(const LthText *text, const char *from, const char *mark) {
  const char *found = memmem(from, (size_t)(text->end - from), mark, strlen(mark));
  return found ? found + strlen(mark) : text->end;
}

static bool is_name(char c) { return isalnum((unsigned char)c) || strchr("_:-.", c) != NULL; }

static const char *read_name(const char *at, const char *end, LthWord *name) {
  name->at = at;
  while (at < end && *at && is_name(*at)) at++;
  name->length = (size_t)(at - name->at);
  return at;
}

/// key="value" or key='value'; NULL where something else stands.
static const char *read_attribute(const char *at, const char *end, LthXmlTag *tag) {
  LthWord key, value;
  at = read_name(at, end, &key);
  while (at < end && isspace((unsigned char)*at)) at++;
  if (key.length == 0 || at == end || *at != '=') return NULL;
  at++;
  while (at < end && isspace((unsigned char)*at)) at++;
  if (at == end || (*at != '"' && *at != '\'')) return NULL;
  const char *close = memchr(at + 1, *at, (size_t)(end - at - 1));
  if (!close) return NULL;
  value = (LthWord){at + 1, (size_t)(close - at - 1)};
  if (tag->n < LTH_XML_ATTRIBUTES_MAX) {
    tag->attribute[tag->n].key = key;
    tag->attribute[tag->n++].value = value;
  }
  return close + 1;
}

/// The tag whose bracket opens at `at`; NULL where it is broken.
static const char *read_tag(const char *at, const char *end, LthXmlTag *tag) {
  *tag = (LthXmlTag){0};
  at++;
  if (at < end && *at == '/') tag->is_end = true, at++;
  at = read_name(at, end, &tag->name);
  if (tag->name.length == 0) return NULL;
  for (;;) {
    while (at < end && (isspace((unsigned char)*at) || *at == '/')) at++;
    if (at == end) return NULL;
    if (*at == '>') break;
    at = read_attribute(at, end, tag);
    if (!at) return NULL;
  }
  tag->content = at + 1;
  return at + 1;
}

bool lth_xml_next(LthText *text, LthXmlTag *tag) {
  while (text->at < text->end) {
    const char *open = memchr(text->at, '<', (size_t)(text->end - text->at));
    if (!open) break;
    move_to(text, open);
    const char *after = NULL;
    if (text->end - open > 3 && memcmp(open, "<!--", 4) == 0)
      move_to(text, behind(text, open + 4, "-->"));
    else if (text->end - open > 1 && (open[1] == '?' || open[1] == '!'))
      move_to(text, behind(text, open, ">"));
    else if ((after = read_tag(open, text->end, tag)) == NULL)
      move_to(text, open + 1);
    if (!after) continue;
    move_to(text, after);
    return true;
  }
  text->at = text->end;
  return false;
}

LthWord lth_xml_attribute(const LthXmlTag *tag, const char *key) {
  for (int i = 0; i < tag->n; i++)
    if (lth_word_is(tag->attribute[i].key, key)) return tag->attribute[i].value;
  return (LthWord){"", 0};
}
