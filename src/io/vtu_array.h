/// DataArrays of VTK's XML files: text, base64 or raw bytes, appended or not, compressed by zlib or not.
#pragma once

#include "io/text.h"

/// How the values of a file are written.
typedef struct LthVtuCoding {
  LitheCtx *ctx;
  const char *file;
  bool is_big, has_wide_head, is_compressed; ///< byte order; UInt64 block headers; zlib
  bool appended_is_base64;
  const char *appended, *appended_end; ///< behind the underscore; NULL: there is none
} LthVtuCoding;

typedef enum LthVtuType {
  LTH_VTU_INT8,
  LTH_VTU_UINT8,
  LTH_VTU_INT16,
  LTH_VTU_UINT16,
  LTH_VTU_INT32,
  LTH_VTU_UINT32,
  LTH_VTU_INT64,
  LTH_VTU_UINT64,
  LTH_VTU_FLOAT32,
  LTH_VTU_FLOAT64,
  LTH_VTU_TYPES
} LthVtuType;

/// A DataArray as its tag describes it.
typedef struct LthVtuSource {
  LthWord name;
  LthVtuType type;
  LitheIndex components;
  enum { LTH_VTU_ASCII, LTH_VTU_BINARY, LTH_VTU_APPENDED } format;
  LthWord content;   ///< between the tags
  LitheCount offset; ///< of appended data
  LitheCount line;   ///< of its tag
} LthVtuSource;

/// Type of a name as "Float32", LTH_VTU_TYPES where it is none.
LthVtuType lth_vtu_type(LthWord name);

/// All values of an array; the caller frees them. Floats that are whole numbers pass as integers.
LitheStatus lth_vtu_read_doubles(const LthVtuCoding *coding, const LthVtuSource *source,
                                 double **values, LitheCount *n);
LitheStatus lth_vtu_read_integers(const LthVtuCoding *coding, const LthVtuSource *source,
                                  int64_t **values, LitheCount *n);

/// LITHE_BAD_INPUT with file, line and name of the array in front.
LitheStatus lth_vtu_array_fail(const LthVtuCoding *coding, const LthVtuSource *source,
                               const char *format, ...) __attribute__((format(printf, 3, 4)));
