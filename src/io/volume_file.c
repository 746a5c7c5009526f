/// Volume files by their endings.
#include "io/volume_file.h"

#include "io/file.h"
#include "io/text.h"
#include "io/volume_data.h"

#include <string.h>
#include <strings.h>

static bool ends_in(const char *path, const char *ending) {
  size_t n = strlen(path), m = strlen(ending);
  return n > m && strcasecmp(path + n - m, ending) == 0;
}

static const char *format_of(const char *path) {
  static const char *const endings[][2] = {{".nii", "nii"},   {".nii.gz", "nii"}, {".nrrd", "nrrd"},
                                           {".nhdr", "nrrd"}, {".mhd", "mhd"},    {".mha", "mhd"},
                                           {".png", "png"}};
  for (size_t i = 0; i < sizeof endings / sizeof *endings; i++)
    if (ends_in(path, endings[i][0])) return endings[i][1];
  return NULL;
}

static LitheStatus parse(LitheCtx *ctx, const char *name, const char *path, const char *format,
                         const char *data, size_t size, LthVolume **volume) {
  *volume = NULL;
  if (strcmp(format, "nii") == 0) return lth_nifti_parse(ctx, name, data, size, volume);
  if (strcmp(format, "png") == 0) return lth_png_parse(ctx, name, data, size, volume);
  LthTextLocale before = lth_text_locale_begin();
  LitheStatus status = strcmp(format, "nrrd") == 0
                           ? lth_nrrd_parse(ctx, name, path, data, size, volume)
                           : lth_mhd_parse(ctx, name, path, data, size, volume);
  lth_text_locale_end(before);
  return status;
}

LitheStatus lth_volume_parse(LitheCtx *ctx, const char *name, const char *format, const char *data,
                             size_t size, LthVolume **volume) {
  return parse(ctx, name, NULL, format, data, size, volume);
}

LitheStatus lth_volume_read(LitheCtx *ctx, const char *path, LthVolume **volume) {
  char *data = NULL;
  size_t size = 0;
  *volume = NULL;
  const char *format = format_of(path);
  if (!format)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: no kind of volume is known by this ending; expected .nii, .nii.gz, .nrrd, "
               ".nhdr, .mhd, .mha or .png",
               path);
  LITHE_TRY(lth_file_read(ctx, path, &data, &size));
  LitheStatus status = parse(ctx, path, path, format, data, size, volume);
  lth_free(ctx, data);
  return status;
}
