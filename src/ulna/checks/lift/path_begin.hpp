// Before a unit's unit.c: its numbers become paths, and what it refuses an exception.
#include "path.hpp"

#include <stdexcept>

#define real Path
#define double Path
#define _Static_assert static_assert
#include "unit.h"

// A step that a unit refuses has no path; a warning changes none.
template <class... Values> Status report(Log *, Status status, const char *format, const Values &...)
{
    if (status > STATUS_WARNING) {
        throw std::runtime_error(format);
    }
    return status;
}
