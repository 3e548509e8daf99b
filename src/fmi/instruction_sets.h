/* A loop compiled for the baseline, and where GCC or Clang compile for x86-64 for AVX2 and AVX-512 too; the widest that
 * the processor has is found at run time. Each copy has the same operations in the same order, so all give the same bits
 * where no product is fused. ULNA_PLAIN leaves the wide ones out.
 */
#ifndef INSTRUCTION_SETS_H
#define INSTRUCTION_SETS_H

#include <stdbool.h>

/* Into a caller that is compiled for wider vectors. */
#if defined(__GNUC__)
#define INLINED static inline __attribute__((always_inline))
#else
#define INLINED static inline
#endif

/* Of a call of INLINED functions: NAME_plain, NAME_avx2 and NAME_avx512, and NAME, the table of those that are compiled. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(ULNA_PLAIN)
#if defined(__clang__)
#define WIDEST "avx512f,avx512vl,avx512dq"
#else
#define WIDEST "avx512f,avx512vl,avx512dq,prefer-vector-width=512"
#endif
#define IN_EVERY_INSTRUCTION_SET(NAME, PARAMETERS, CALL)                          \
    static void NAME##_plain PARAMETERS { CALL; }                                 \
    __attribute__((target("avx2"))) static void NAME##_avx2 PARAMETERS { CALL; }  \
    __attribute__((target(WIDEST))) static void NAME##_avx512 PARAMETERS { CALL; } \
    static void (*const NAME[]) PARAMETERS = {NAME##_plain, NAME##_avx2, NAME##_avx512};

/* Index in those tables. */
static inline int widest_instruction_set(void)
{
    bool wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq");
    return wide ? 2 : __builtin_cpu_supports("avx2") ? 1 : 0;
}
#else
#define IN_EVERY_INSTRUCTION_SET(NAME, PARAMETERS, CALL) \
    static void NAME##_plain PARAMETERS { CALL; }        \
    static void (*const NAME[]) PARAMETERS = {NAME##_plain};

static inline int widest_instruction_set(void)
{
    return 0;
}
#endif

#endif
