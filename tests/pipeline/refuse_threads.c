/* For LD_PRELOAD: from the NLG_TEST_REFUSE_THREADS_FROM-th on, counted from 1, the system makes no more threads. A limit on processes does
 * the same, but not to root. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*), void* argument) {
  static atomic_int asked_for;
  int (*next)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  const char* const from = getenv("NLG_TEST_REFUSE_THREADS_FROM");
  if (from != NULL && atomic_fetch_add(&asked_for, 1) + 1 >= atoi(from)) return EAGAIN;
  *(void**)&next = dlsym(RTLD_NEXT, "pthread_create");
  return next(thread, attributes, start, argument);
}
