/// YAML 1.2 text (and so JSON) into nodes with their places.
#pragma once

#include "scene/report.h"

/// Largest scene file that is read.
#define LTH_YAML_BYTES_MAX (16 << 20)

/// Parse one document. Syntax errors, repeated keys, unknown anchors, a second document, text that is
/// not UTF-8, and documents too deep or too large go into `report`; NULL where nothing can be used or
/// memory is out. `origin` (may be NULL) is given to all nodes.
LthNode *lth_yaml_parse(LthReport *report, const char *text, size_t length, const char *origin);
