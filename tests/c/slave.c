/* What both versions of the standard share. */
#include "check.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static _Atomic size_t failures; /* threads check too */

size_t failure_count(void)
{
    return failures;
}

void fail(const char *file, int line, const char *condition, const char *format, ...)
{
    enum { PRINTED_FAILURES = 30 };
    if (++failures > PRINTED_FAILURES) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "%s:%d: %s fails: ", file, line, condition);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

void check_refused(const char *file, int line, Slave *slave, int status, const char *what, const char *const words[])
{
    if (status != ERROR) {
        fail(file, line, "status is error", "%s: status %d", what, status);
    }
    if (slave->log.lines == 0) {
        fail(file, line, "a line is logged", "%s", what);
    }
    for (size_t i = 0; words[i]; i++) {
        if (!strstr(slave->log.text, words[i])) {
            fail(file, line, "the log line names it", "%s: '%s' not in '%s'", what, words[i], slave->log.text);
        }
    }
    slave->log = (LogRecord){0};
}

void record_line(LogRecord *log, int status, const char *category, const char *text)
{
    log->lines++;
    log->status = status;
    snprintf(log->category, sizeof log->category, "%s", category);
    snprintf(log->text, sizeof log->text, "%s", text);
}

void slave_open(Slave *slave, Kind kind)
{
    slave_open_as(slave, kind, "test", subject()->token);
    CHECK(slave->instance, "kind %d: %s", (int)kind, slave->log.text);
}

void slave_start(Slave *slave)
{
    int status = slave_enter_initialization(slave, 0.0, NULL);
    if (status == OK) {
        status = slave_exit_initialization(slave);
    }
    if (status == OK) {
        status = slave_enter_continuous_time(slave);
    }
    CHECK(status == OK, "start: %s", slave->log.text);
}

static bool has_mode(Kind kind, Mode mode)
{
    switch (mode) {
    case EVENT: return kind != CO_SIMULATION;
    case CONTINUOUS_TIME: return kind == MODEL_EXCHANGE;
    case STEP: return kind != MODEL_EXCHANGE;
    default: return true;
    }
}

bool slave_reach(Slave *slave, Mode mode)
{
    if (!has_mode(slave->kind, mode)) {
        return false;
    }
    if (mode == CONFIGURATION) {
        return slave_enter_configuration(slave) == OK;
    }
    int status = OK;
    if (mode & (INITIALIZATION | EVENT)) {
        status = slave_enter_initialization(slave, 0.0, NULL);
    }
    if (mode == EVENT) {
        status |= slave_exit_initialization(slave);
    }
    if (mode & (CONTINUOUS_TIME | STEP | TERMINATED)) {
        slave_start(slave);
    }
    if (mode == TERMINATED) {
        status |= slave_terminate(slave);
    }
    CHECK(status == OK, "mode %d: %s", (int)mode, slave->log.text);
    return status == OK;
}
