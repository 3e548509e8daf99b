/* The folder of an FMU's resources: FMI 2 gives a URI, FMI 3 a path, with or without a separator at its end. */
#include "instance.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int hexadecimal(char c)
{
    const char *digits = "0123456789abcdef0123456789ABCDEF";
    const char *place = c ? strchr(digits, c) : NULL;
    return place ? (int)((place - digits) % 16) : -1;
}

/* The path in "file:///tmp/a%20b", "file:/tmp", "file://localhost/tmp" and "file:///C:/tmp". */
static const char *path_of_uri(const char *uri)
{
    const char *path = uri + strlen("file:");
    if (strncmp(path, "//", 2) == 0) {
        const char *after_host = strchr(path + 2, '/');
        path = after_host ? after_host : path + 2;
    }
    bool drive = path[0] == '/' && path[1] && path[2] == ':';
    return drive ? path + 1 : path;
}

static void decode(char *text)
{
    char *to = text;
    for (const char *from = text; *from; from++) {
        int high = *from == '%' ? hexadecimal(from[1]) : -1;
        int low = high >= 0 ? hexadecimal(from[2]) : -1;
        *to++ = low >= 0 ? (char)(16 * high + low) : *from;
        from += low >= 0 ? 2 : 0;
    }
    *to = '\0';
}

/* A copy that ends in a separator, empty where there is no folder; NULL without memory. */
static char *resource_folder(const char *location)
{
    bool uri = location && strncmp(location, "file:", strlen("file:")) == 0;
    const char *path = uri ? path_of_uri(location) : location ? location : "";
    char *folder = calloc(1, strlen(path) + 2);
    if (folder) {
        memcpy(folder, path, strlen(path));
        if (uri) {
            decode(folder);
        }
        size_t size = strlen(folder);
        if (size && folder[size - 1] != '/' && folder[size - 1] != '\\') {
            folder[size] = '/';
            folder[size + 1] = '\0';
        }
    }
    return folder;
}

static bool resource_is_there(const char *folder, const char *name)
{
    char path[4096];
    int length = snprintf(path, sizeof path, "%s%s", folder, name);
    FILE *file = *folder && length > 0 && (size_t)length < sizeof path ? fopen(path, "rb") : NULL;
    if (file) {
        fclose(file);
    }
    return file != NULL;
}
