/// Overrides of the command line: "bodies.0.method.degree=2".
#pragma once

#include "scene/report.h"

/// Put a value into the document; missing mappings on the way are made, and one entry may be added behind
/// a list. What is wrong goes into the report.
void lth_override(LthReport *report, LthNode *root, const char *override);
