/* Preloaded into a tool: counts its system calls by class, and strikes at one of them.
 *
 *   INJECT_COUNTS=FILE   a line "class count" for every class, appended when the process ends by itself
 *   INJECT_CALL=write    the class to strike in: open read write sync rename truncate map close folder unlink thread memory
 *   INJECT_AT=17         which of its calls, from 1
 *   INJECT_FAULT=kill    SIGKILL before the call; tear: half of a write, then SIGKILL; short: half of a read or write; a number: the
 *                        call fails with that errno
 *   INJECT_STAY=1        every later call of the class fails too: a disk stays full
 *   INJECT_UNDER=FOLDER  calls on files inside it alone (an absolute path without links); threads and memory have no file
 *   INJECT_ABOVE=BYTES   memory: allocations of at least this size
 *   INJECT_PROGRAM=NAME  processes of that name alone
 *
 * What the C library calls inside itself is not seen: fopen, fread, fwrite and fclose stand for it. */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <malloc.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

enum Class { kOpen, kRead, kWrite, kSync, kRename, kTruncate, kMap, kClose, kFolder, kUnlink, kThread, kMemory, kClassCount };
static const char* const kNames[kClassCount] = {"open", "read",  "write",  "sync",   "rename", "truncate",
                                                "map",  "close", "folder", "unlink", "thread", "memory"};

/* What the n-th call does instead; a positive number is an errno. */
enum { kNothing = 0, kShort = -1 };

static atomic_long counts[kClassCount];
static int struck = -1; /* a class, or none */
static long struck_at;
static int fault, stays, kills, tears;
static size_t above = SIZE_MAX;
static char under[4096];
static int is_on;

static void* next(const char* name) { return dlsym(RTLD_NEXT, name); }

__attribute__((constructor)) static void begin(void) {
  const char* const program = getenv("INJECT_PROGRAM");
  const char* const call = getenv("INJECT_CALL");
  const char* const what = getenv("INJECT_FAULT");
  if (program != NULL && strncmp(program, program_invocation_short_name, strlen(program)) != 0) return;
  if (getenv("INJECT_UNDER") != NULL) snprintf(under, sizeof under, "%s", getenv("INJECT_UNDER"));
  if (getenv("INJECT_ABOVE") != NULL) above = strtoull(getenv("INJECT_ABOVE"), NULL, 10);
  if (call != NULL && what != NULL && getenv("INJECT_AT") != NULL) {
    for (int c = 0; c < kClassCount; ++c) {
      if (strcmp(call, kNames[c]) == 0) struck = c;
    }
    struck_at = atol(getenv("INJECT_AT"));
    kills = strcmp(what, "kill") == 0;
    tears = strcmp(what, "tear") == 0;
    fault = strcmp(what, "short") == 0 ? kShort : atoi(what);
    stays = getenv("INJECT_STAY") != NULL;
  }
  is_on = 1;
}

__attribute__((destructor)) static void end(void) {
  const char* const path = getenv("INJECT_COUNTS");
  if (!is_on || path == NULL) return;
  is_on = 0;
  FILE* const file = fopen(path, "a");
  if (file == NULL) return;
  for (int c = 0; c < kClassCount; ++c) fprintf(file, "%s %ld\n", kNames[c], atomic_load(&counts[c]));
  fclose(file);
}

/* Counts one call; what it must do instead. */
static int strike(int of) {
  const long n = atomic_fetch_add(&counts[of], 1) + 1;
  if (of != struck || (stays ? n < struck_at : n != struck_at)) return kNothing;
  if (kills) kill(getpid(), SIGKILL);
  return tears ? kShort : fault;
}

static int isInside(const char* path) {
  const size_t length = strlen(under);
  return length == 0 || (strncmp(path, under, length) == 0 && (path[length] == '/' || path[length] == '\0'));
}

static int strikePath(int of, const char* path) {
  char absolute[8192];
  if (!is_on || path == NULL) return kNothing;
  if (path[0] != '/') {
    char folder[4096];
    if (getcwd(folder, sizeof folder) == NULL) return kNothing;
    snprintf(absolute, sizeof absolute, "%s/%s", folder, path);
    path = absolute;
  }
  return isInside(path) ? strike(of) : kNothing;
}

static int strikeFile(int of, int file) {
  char link[64], path[4096];
  ssize_t length;
  if (!is_on || file < 0) return kNothing;
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  length = readlink(link, path, sizeof path - 1);
  if (length <= 0) return kNothing;
  path[length] = '\0';
  return path[0] == '/' && isInside(path) ? strike(of) : kNothing;
}

/* A stream remembers that it failed, or its user takes the failure for the file's end. */
static int strikeStream(int of, FILE* stream) {
  const int failed = strikeFile(of, fileno(stream));
  if (failed > 0) stream->_flags |= 0x20; /* _IO_ERR_SEEN */
  return failed;
}

/* Before a call of the name below that returns `bad` when it fails. */
#define FAIL_IF(found, bad)     \
  do {                          \
    const int failed = (found); \
    if (failed > 0) {           \
      errno = failed;           \
      return (bad);             \
    }                           \
  } while (0)

static mode_t modeOf(int flags, va_list arguments) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

#define OPEN(name)                                                           \
  int name(const char* path, int flags, ...) {                               \
    va_list arguments;                                                       \
    va_start(arguments, flags);                                              \
    const mode_t mode = modeOf(flags, arguments);                            \
    va_end(arguments);                                                       \
    FAIL_IF(strikePath(kOpen, path), -1);                                    \
    return ((int (*)(const char*, int, ...))next(#name))(path, flags, mode); \
  }
OPEN(open)
OPEN(open64)

#define OPEN_AT(name)                                                                     \
  int name(int folder, const char* path, int flags, ...) {                                \
    va_list arguments;                                                                    \
    va_start(arguments, flags);                                                           \
    const mode_t mode = modeOf(flags, arguments);                                         \
    va_end(arguments);                                                                    \
    if (folder == AT_FDCWD || path[0] == '/') FAIL_IF(strikePath(kOpen, path), -1);       \
    return ((int (*)(int, const char*, int, ...))next(#name))(folder, path, flags, mode); \
  }
OPEN_AT(openat)
OPEN_AT(openat64)

#define FOPEN(name)                                                          \
  FILE* name(const char* path, const char* mode) {                           \
    FAIL_IF(strikePath(kOpen, path), NULL);                                  \
    return ((FILE * (*)(const char*, const char*)) next(#name))(path, mode); \
  }
FOPEN(fopen)
FOPEN(fopen64)

ssize_t read(int file, void* bytes, size_t count) {
  const int found = strikeFile(kRead, file);
  FAIL_IF(found, -1);
  return ((ssize_t(*)(int, void*, size_t))next("read"))(file, bytes, found == kShort && count > 1 ? count / 2 : count);
}

#define PREAD(name, offset_type)                                                                                                \
  ssize_t name(int file, void* bytes, size_t count, offset_type first) {                                                        \
    const int found = strikeFile(kRead, file);                                                                                  \
    FAIL_IF(found, -1);                                                                                                         \
    return ((ssize_t(*)(int, void*, size_t, offset_type))next(#name))(file, bytes,                                              \
                                                                      found == kShort && count > 1 ? count / 2 : count, first); \
  }
PREAD(pread, off_t)
PREAD(pread64, off64_t)

size_t fread(void* bytes, size_t size, size_t count, FILE* stream) {
  FAIL_IF(strikeStream(kRead, stream), 0);
  return ((size_t(*)(void*, size_t, size_t, FILE*))next("fread"))(bytes, size, count, stream);
}

/* Half a write, and the end of the process where that is the fault. */
static ssize_t halfOf(ssize_t written) {
  if (tears) kill(getpid(), SIGKILL);
  return written;
}

ssize_t write(int file, const void* bytes, size_t count) {
  ssize_t (*const real)(int, const void*, size_t) = (ssize_t(*)(int, const void*, size_t))next("write");
  const int found = strikeFile(kWrite, file);
  FAIL_IF(found, -1);
  return found == kShort ? halfOf(real(file, bytes, count > 1 ? count / 2 : count)) : real(file, bytes, count);
}

ssize_t writev(int file, const struct iovec* parts, int part_count) {
  const int found = strikeFile(kWrite, file);
  FAIL_IF(found, -1);
  /* a short one ends with the first part */
  ssize_t (*const real)(int, const struct iovec*, int) = (ssize_t(*)(int, const struct iovec*, int))next("writev");
  return found == kShort ? halfOf(real(file, parts, part_count > 1 ? 1 : part_count)) : real(file, parts, part_count);
}

#define PWRITE(name, offset_type)                                                                                               \
  ssize_t name(int file, const void* bytes, size_t count, offset_type first) {                                                  \
    ssize_t (*const real)(int, const void*, size_t, offset_type) =                                                              \
        (ssize_t(*)(int, const void*, size_t, offset_type))next(#name);                                                         \
    const int found = strikeFile(kWrite, file);                                                                                 \
    FAIL_IF(found, -1);                                                                                                         \
    return found == kShort ? halfOf(real(file, bytes, count > 1 ? count / 2 : count, first)) : real(file, bytes, count, first); \
  }
PWRITE(pwrite, off_t)
PWRITE(pwrite64, off64_t)

size_t fwrite(const void* bytes, size_t size, size_t count, FILE* stream) {
  FAIL_IF(strikeStream(kWrite, stream), 0);
  return ((size_t(*)(const void*, size_t, size_t, FILE*))next("fwrite"))(bytes, size, count, stream);
}

int fsync(int file) {
  FAIL_IF(strikeFile(kSync, file), -1);
  return ((int (*)(int))next("fsync"))(file);
}

int fdatasync(int file) {
  FAIL_IF(strikeFile(kSync, file), -1);
  return ((int (*)(int))next("fdatasync"))(file);
}

int rename(const char* from, const char* to) {
  FAIL_IF(strikePath(kRename, to), -1);
  return ((int (*)(const char*, const char*))next("rename"))(from, to);
}

int symlink(const char* target, const char* path) {
  FAIL_IF(strikePath(kRename, path), -1);
  return ((int (*)(const char*, const char*))next("symlink"))(target, path);
}

#define TRUNCATE(name, offset_type)                              \
  int name(int file, offset_type size) {                         \
    FAIL_IF(strikeFile(kTruncate, file), -1);                    \
    return ((int (*)(int, offset_type))next(#name))(file, size); \
  }
TRUNCATE(ftruncate, off_t)
TRUNCATE(ftruncate64, off64_t)

#define MAP(name, offset_type)                                                                                               \
  void* name(void* place, size_t size, int protection, int flags, int file, offset_type first) {                             \
    FAIL_IF(strikeFile(kMap, file), MAP_FAILED);                                                                             \
    return ((void* (*)(void*, size_t, int, int, int, offset_type))next(#name))(place, size, protection, flags, file, first); \
  }
MAP(mmap, off_t)
MAP(mmap64, off64_t)

/* The file is closed whatever is said of it, as on Linux. */
int close(int file) {
  int (*const real)(int) = (int (*)(int))next("close");
  const int error = strikeFile(kClose, file);
  const int result = real(file);
  FAIL_IF(error, -1);
  return result;
}

int fclose(FILE* stream) {
  int (*const real)(FILE*) = (int (*)(FILE*))next("fclose");
  const int error = is_on && stream != NULL ? strikeFile(kClose, fileno(stream)) : kNothing;
  const int result = real(stream);
  FAIL_IF(error, EOF);
  return result;
}

int mkdir(const char* path, mode_t mode) {
  FAIL_IF(strikePath(kFolder, path), -1);
  return ((int (*)(const char*, mode_t))next("mkdir"))(path, mode);
}

DIR* opendir(const char* path) {
  FAIL_IF(strikePath(kFolder, path), NULL);
  return ((DIR * (*)(const char*)) next("opendir"))(path);
}

int unlink(const char* path) {
  FAIL_IF(strikePath(kUnlink, path), -1);
  return ((int (*)(const char*))next("unlink"))(path);
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*body)(void*), void* argument) {
  const int error = is_on ? strike(kThread) : kNothing;
  if (error > 0) return error;
  return ((int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*))next("pthread_create"))(thread, attributes, body,
                                                                                                       argument);
}

/* The C library's own, so that looking them up takes no memory. */
extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);

/* Bytes that the heaps have of the system. */
static size_t held(void) {
  const struct mallinfo2 all = mallinfo2();
  return all.arena + all.hblkhd;
}

/* What the heaps already had is given without asking the system, which can refuse nothing there: memory that came so stays as it is.
 * `before` is what they held then. */
static void* givenOrRefused(void* memory, size_t before) {
  if (memory == NULL || held() <= before || strike(kMemory) <= 0) return memory;
  free(memory);
  return errno = ENOMEM, NULL;
}

void* malloc(size_t size) {
  if (!is_on || size < above) return __libc_malloc(size);
  const size_t before = held();
  return givenOrRefused(__libc_malloc(size), before);
}

void* calloc(size_t count, size_t size) {
  if (!is_on || size == 0 || count > SIZE_MAX / size || count * size < above) return __libc_calloc(count, size);
  const size_t before = held();
  return givenOrRefused(__libc_calloc(count, size), before);
}

/* By a new block: the C library's own may have moved the old one before it is known that the system was asked. */
void* realloc(void* place, size_t size) {
  const size_t old_size = place == NULL ? 0 : malloc_usable_size(place);
  if (!is_on || size < above || size <= old_size) return __libc_realloc(place, size);
  void* const memory = malloc(size);
  if (memory == NULL) return NULL;
  if (place != NULL) memcpy(memory, place, old_size);
  free(place);
  return memory;
}

void* aligned_alloc(size_t alignment, size_t size) {
  if (!is_on || size < above) return __libc_memalign(alignment, size);
  const size_t before = held();
  return givenOrRefused(__libc_memalign(alignment, size), before);
}

int posix_memalign(void** place, size_t alignment, size_t size) {
  *place = aligned_alloc(alignment, size);
  return *place == NULL ? ENOMEM : 0;
}
