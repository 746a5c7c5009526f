/// Runs a fuzz target once on every file of the folders given: the corpus as an ordinary test.
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/// The contents of a file in a block of exactly its size, so that ASan sees a read behind it.
static uint8_t *read_file(const char *path, size_t *size) {
  FILE *stream = fopen(path, "rb");
  if (!stream) return NULL;
  fseek(stream, 0, SEEK_END);
  long length = ftell(stream);
  rewind(stream);
  uint8_t *data = malloc(length > 0 ? (size_t)length : 1);
  *size = data && length > 0 ? fread(data, 1, (size_t)length, stream) : 0;
  fclose(stream);
  return data;
}

static int replay_file(const char *path) {
  size_t size = 0;
  uint8_t *data = read_file(path, &size);
  if (!data) {
    fprintf(stderr, "%s: cannot be read\n", path);
    return -1;
  }
  // a target that stops the program leaves the name of the file as the last line
  printf("%s\n", path);
  fflush(stdout);
  LLVMFuzzerTestOneInput(data, size);
  free(data);
  return 1;
}

/// Number of files run, -1 where one cannot be read.
static int replay_folder(const char *folder) {
  char path[4096];
  int n = 0;
  DIR *dir = opendir(folder);
  if (!dir) return -1;
  for (struct dirent *entry = readdir(dir); entry && n >= 0; entry = readdir(dir)) {
    if (entry->d_name[0] == '.') continue;
    snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
    n = replay_file(path) < 0 ? -1 : n + 1;
  }
  closedir(dir);
  return n;
}

int main(int argc, char **argv) {
  int n = 0;
  for (int i = 1; i < argc; i++) {
    int in_folder = replay_folder(argv[i]);
    if (in_folder < 0) {
      fprintf(stderr, "%s: cannot be replayed\n", argv[i]);
      return 1;
    }
    n += in_folder;
  }
  printf("%d inputs\n", n);
  return n > 0 ? 0 : 1; // an empty corpus tests nothing
}
