/* Counts what the unit under test asks of the allocator: the linker sends its calls here (--wrap). */
#ifndef ULNA_TEST_ALLOCATIONS_H
#define ULNA_TEST_ALLOCATIONS_H

#include <stddef.h>

/* Calls of malloc, calloc, realloc and free so far, of all threads. */
size_t allocator_calls(void);

/* The n-th allocation after now fails; 0: none. */
void fail_allocation(size_t n);

#endif
