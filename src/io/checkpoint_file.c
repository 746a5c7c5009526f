/// A checkpoint on disk.
///
/// Layout, 32 bytes of head in the machine's own byte order, then the bytes themselves: "LITHECHK", uint32
/// 0x01020304, uint32 format version, uint64 number of bytes, uint64 digest of them.
#include "io/checkpoint_file.h"

#include "base/digest.h"
#include "io/file.h"

#include <string.h>
#include <unistd.h>

#define FORMAT_VERSION 1
#define ORDER 0x01020304u
#define ORDER_SWAPPED 0x04030201u

typedef struct Head {
  char magic[8];
  uint32_t order, version;
  uint64_t size, digest;
} Head;

static const char magic[8] = {'L', 'I', 'T', 'H', 'E', 'C', 'H', 'K'};

LitheStatus lth_checkpoint_write(LitheCtx *ctx, const char *path, const char *data,
                                 LitheCount size) {
  LthFileWriter writer;
  Head head = {.order = ORDER,
               .version = FORMAT_VERSION,
               .size = (uint64_t)size,
               .digest = lth_digest(data, (size_t)size, 0)};
  memcpy(head.magic, magic, sizeof magic);
  LITHE_TRY(lth_file_open(ctx, path, &writer));
  fwrite(&head, sizeof head, 1, writer.stream);
  fwrite(data, 1, (size_t)size, writer.stream);
  // a failure to write is seen by the commit; one to reach the disk must keep the older file
  if (fflush(writer.stream) == 0) fsync(fileno(writer.stream));
  return lth_file_commit(ctx, &writer);
}

static LitheStatus check_head(LitheCtx *ctx, const char *path, const Head *head, size_t n_bytes) {
  if (n_bytes < sizeof *head || memcmp(head->magic, magic, sizeof magic) != 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: this is not a checkpoint of lithe", path);
  if (head->order == ORDER_SWAPPED)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: the checkpoint was written on a machine of the other byte order; go on there, "
               "or run the scene anew",
               path);
  if (head->order != ORDER || head->version != FORMAT_VERSION)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: the checkpoint has format version %u, this program reads %d; go on with the "
               "program that wrote it, or run the scene anew",
               path, head->version, FORMAT_VERSION);
  if (head->size != n_bytes - sizeof *head)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: the checkpoint is damaged: got %zu bytes, expected %llu; run the scene anew",
               path, n_bytes - sizeof *head, (unsigned long long)head->size);
  return LITHE_OK;
}

LitheStatus lth_checkpoint_read(LitheCtx *ctx, const char *path, char **data, LitheCount *size) {
  Head head = {0};
  size_t n_bytes;
  *size = 0;
  LITHE_TRY(lth_file_read(ctx, path, data, &n_bytes));
  memcpy(&head, *data, n_bytes < sizeof head ? n_bytes : sizeof head);
  LitheStatus status = check_head(ctx, path, &head, n_bytes);
  if (status == LITHE_OK) {
    *size = (LitheCount)head.size;
    memmove(*data, *data + sizeof head, (size_t)head.size);
    if (lth_digest(*data, (size_t)head.size, 0) != head.digest)
      status = lth_fail(ctx, LITHE_BAD_INPUT,
                        "%s: the checkpoint is damaged: its bytes do not fit their digest; run the "
                        "scene anew",
                        path);
  }
  if (status == LITHE_OK) return LITHE_OK;
  lth_free(ctx, *data);
  *data = NULL;
  *size = 0;
  return status;
}
