/// A 64-bit fingerprint of bytes: guards against accidents, not against intent.
#pragma once

#include "base/ctx.h"

/// The same on every machine and in every build. `seed` is 0, or the digest of what came before.
uint64_t lth_digest(const void *data, size_t size, uint64_t seed);
