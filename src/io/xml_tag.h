/// Tags of an XML file one after the other, as far as VTK's files need it: no entities, no nesting checks.
#pragma once

#include "io/text.h"

#define LTH_XML_ATTRIBUTES_MAX 32

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
