#include "allocations.h"

#include <stdatomic.h>

static atomic_size_t count;
static atomic_size_t until_failure;

size_t allocator_calls(void)
{
    return count;
}

void fail_allocation(size_t n)
{
    until_failure = n;
}

/* Whether this allocation is the one to fail. */
static int is_due(void)
{
    count++;
    size_t left = until_failure;
    until_failure = left ? left - 1 : 0;
    return left == 1;
}

void *__real_malloc(size_t size);
void *__real_calloc(size_t members, size_t size);
void *__real_realloc(void *memory, size_t size);
void __real_free(void *memory);

void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t members, size_t size);
void *__wrap_realloc(void *memory, size_t size);
void __wrap_free(void *memory);

void *__wrap_malloc(size_t size)
{
    return is_due() ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t members, size_t size)
{
    return is_due() ? NULL : __real_calloc(members, size);
}

void *__wrap_realloc(void *memory, size_t size)
{
    return is_due() ? NULL : __real_realloc(memory, size);
}

void __wrap_free(void *memory)
{
    count++;
    __real_free(memory);
}
