/* Steps the time of day of one program: preloaded, it adds the number of seconds that stands in
 * the file SLAMLAB_CLOCK_STEP (a 64-bit integer, mapped) to what the system says. Clocks that
 * count since the start stay as they are. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

static const volatile int64_t *step;

__attribute__((constructor)) static void map_step(void) {
  const char *path = getenv("SLAMLAB_CLOCK_STEP");
  int file = path ? open(path, O_RDONLY | O_CLOEXEC) : -1;
  if (file < 0) return;
  void *at = mmap(NULL, sizeof *step, PROT_READ, MAP_SHARED, file, 0);
  if (at != MAP_FAILED) step = at;
  close(file);
}

int clock_gettime(clockid_t clock, struct timespec *time) {
  int result = syscall(SYS_clock_gettime, clock, time);
  if (result == 0 && clock == CLOCK_REALTIME && step) time->tv_sec += *step;
  return result;
}
