/// What this build of the library is: version, options, engines, licence.
#pragma once

#include "lithe/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Write the lines of `lithe info` into `text` (`size` bytes, cut short where they do not fit, 0 at the
/// end). Returns the bytes that the whole text needs, without the 0, as snprintf does.
LITHE_API size_t lithe_info(char *text, size_t size);

#ifdef __cplusplus
}
#endif
