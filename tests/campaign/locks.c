/* Loaded before the C library: a file system without locks (LOCKS=flock:37 or LOCKS=fcntl:37, the
   kind that is missing and its error), or one that keeps the locks of every machine apart
   (LOCKS=apart). */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

static int missing(const char *kind)
{
    const char *locks = getenv("LOCKS");
    size_t length = strlen(kind);
    if (!locks || strncmp(locks, kind, length) || locks[length] != ':') return 0;
    return errno = atoi(locks + length + 1);
}

int flock(int file, int operation)
{
    const char *locks = getenv("LOCKS");
    if (locks && !strcmp(locks, "apart")) return 0;
    if (missing("flock")) return -1;
    return ((int (*)(int, int))dlsym(RTLD_NEXT, "flock"))(file, operation);
}

static int control(const char *name, int file, int command, void *argument)
{
    if ((command == F_SETLK || command == F_SETLKW) && missing("fcntl")) return -1;
    return ((int (*)(int, int, ...))dlsym(RTLD_NEXT, name))(file, command, argument);
}

#define CONTROL(name)                                \
    int name(int file, int command, ...)             \
    {                                                \
        va_list rest;                                \
        va_start(rest, command);                     \
        void *argument = va_arg(rest, void *);       \
        va_end(rest);                                \
        return control(#name, file, command, argument); \
    }

CONTROL(fcntl)
CONTROL(fcntl64)
