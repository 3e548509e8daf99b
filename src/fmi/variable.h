/* One row of the table of variables, which is generated from unit.toml. */
#ifndef ULNA_VARIABLE_H
#define ULNA_VARIABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum ValueType { FLOAT64, FLOAT32, INT32, UINT64, BOOLEAN, ENUMERATION, BINARY, CLOCK, VALUE_TYPES } ValueType;

typedef enum Causality {
    INDEPENDENT,
    STRUCTURAL_PARAMETER,
    PARAMETER,
    INPUT,
    OUTPUT,
    LOCAL,
    MEMORY /* saved with the state, not visible */
} Causality;

typedef enum Variability { CONSTANT, FIXED, TUNABLE, DISCRETE, CONTINUOUS } Variability;

enum {
    NO_GROUP = 255,      /* a value that is set, not computed */
    STREAM = 254,        /* computed when read, into the reader's memory */
    NO_VARIABLE = 0xFFFF
};

typedef struct Variable {
    const char *name;       /* as in the model description */
    const char *unit;       /* SI, as in the model description */
    uint8_t type;           /* ValueType */
    uint8_t causality;      /* Causality */
    uint8_t variability;    /* Variability */
    uint8_t group;          /* index into Unit.evaluate, NO_GROUP or STREAM */
    uint16_t rate;          /* index of the input that holds this one's slope, or NO_VARIABLE */
    bool quaternion;        /* its norm is checked */
    bool state;             /* a continuous state; its derivative is the row after it */
    bool countdown;         /* a clock that the unit times; what was said of it are the two rows after it */
    size_t offset;          /* in the unit's struct, bytes; 0 where it is no field of it */
    uint32_t reference;     /* value reference of the first element; the others follow */
    uint32_t count;         /* elements, of a BINARY its bytes; per size_of, if there is one */
    uint32_t size_of;       /* offset in the struct of the uint64_t that multiplies count, or 0 */
    double minimum, maximum;
    double nominal;
} Variable;

/* Whether its elements are a field of the struct: else a stream, or an array behind it. */
static inline bool is_field(const Variable *variable)
{
    return variable->group != STREAM && !variable->size_of;
}

#endif
