/* What goes wrong, said through the importer's logger. */
#include "instance.h"

#include <stdarg.h>
#include <stdio.h>

static void log_line(Log *log, Status status, unsigned category, const char *name, const char *format, va_list arguments)
{
    char message[512];
    if (!(log->categories & category) || !log->callback) {
        return;
    }
    vsnprintf(message, sizeof message, format, arguments);
    log->send(log, status, name, message);
}

static Status report(Log *log, Status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    bool warning = status == STATUS_WARNING;
    log_line(log, status, warning ? LOG_WARNINGS : LOG_ERRORS, warning ? "logStatusWarning" : "logStatusError", format,
             arguments);
    va_end(arguments);
    return status;
}

static void report_event(Log *log, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    log_line(log, STATUS_OK, LOG_EVENTS, "logEvents", format, arguments);
    va_end(arguments);
}
