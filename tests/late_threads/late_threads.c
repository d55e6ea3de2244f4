/* Holds back every thread but the first once it has woken another one, until `release` is called.
 *
 * A loaded machine does that by chance: a thread of a library's pool hands over its result and is not scheduled again
 * for a while, with references of its own still to be dropped.  Preloaded (LD_PRELOAD), this makes it the rule.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <pthread.h>
#include <stdatomic.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

static const double LONGEST = 0.25; /* s that a thread is held where nobody calls `release` */
static atomic_int released, held;
static __thread int has_woken;

static int is_first_thread(void) { return getpid() == (pid_t)syscall(SYS_gettid); }

static void pause_for(double seconds) {
    struct timespec span = {(time_t)seconds, (long)((seconds - (time_t)seconds) * 1e9)};
    nanosleep(&span, NULL);
}

/* Not pthread_cond_signal: by that Python's own threads hand over the interpreter, thousands of times. */
int pthread_cond_broadcast(pthread_cond_t *condition) {
    static int (*real)(pthread_cond_t *);
    if (!real)
        real = (int (*)(pthread_cond_t *))dlsym(RTLD_NEXT, "pthread_cond_broadcast");
    has_woken = !is_first_thread();
    return real(condition);
}

/* The waking thread still has the lock; it is held back as soon as it has given that up. */
int pthread_mutex_unlock(pthread_mutex_t *mutex) {
    static int (*real)(pthread_mutex_t *);
    if (!real)
        real = (int (*)(pthread_mutex_t *))dlsym(RTLD_NEXT, "pthread_mutex_unlock");
    int outcome = real(mutex);
    if (has_woken) {
        has_woken = 0;
        held += 1;
        for (double waited = 0.0; !released && waited < LONGEST; waited += 0.005)
            pause_for(0.005);
    }
    return outcome;
}

/* Lets all of them go on, gives them time to come to where they need the interpreter, and returns how many were held. */
int release(void) {
    released = 1;
    if (held)
        pause_for(0.03);
    return held;
}
