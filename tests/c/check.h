/* Checks that count their failures and go on, so that one run tells all that is wrong. */
#ifndef ULNA_TEST_CHECK_H
#define ULNA_TEST_CHECK_H

#include "slave.h"

/* Counts and prints a failure. */
void fail(const char *file, int line, const char *condition, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

size_t failure_count(void);

#define CHECK(condition, ...)                                      \
    do {                                                           \
        if (!(condition)) {                                        \
            fail(__FILE__, __LINE__, #condition, __VA_ARGS__);     \
        }                                                          \
    } while (0)

/* The call returned an error and its log line holds all of these words; forgets the line. */
#define CHECK_REFUSED(slave, status, what, ...) \
    check_refused(__FILE__, __LINE__, slave, status, what, (const char *[]){__VA_ARGS__, NULL})

void check_refused(const char *file, int line, Slave *slave, int status, const char *what, const char *const words[]);

#endif
