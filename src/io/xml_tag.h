/// Text for XML files; and reading their tags one after the other, as far as VTK's files need it: no entities, no
/// nesting checks.
#pragma once

#include "io/text.h"

#include <stdio.h>

#define LTH_XML_ATTRIBUTES_MAX 32

/// What stands for a letter in XML, NULL where it stands for itself.
const char *lth_xml_entity(char letter);

/// Write text with its special letters escaped.
void lth_xml_put_text(FILE *out, const char *text);

/// `<name key="value" ...>`, `</name>` or `<name .../>`. Words point into the file.
typedef struct LthXmlTag {
  LthWord name;
  bool is_end;
  int n;
  struct {
    LthWord key, value;
  } attribute[LTH_XML_ATTRIBUTES_MAX];
  const char *content; ///< behind the closing bracket
} LthXmlTag;

/// The next tag; false at the end of the text. Comments, declarations and broken tags are passed over.
bool lth_xml_next(LthText *text, LthXmlTag *tag);

/// Value of an attribute; a word of length 0 where the tag does not have it.
LthWord lth_xml_attribute(const LthXmlTag *tag, const char *key);
