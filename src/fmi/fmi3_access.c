/* FMI 3.0: getting and setting, one function a type, all through the same loop. */
#include "fmi3Functions.h"

#include "instance.h"

/* A type that the table knows. Enumerations travel as Int64. */
#define ACCESS(TYPE, KIND)                                                                                              \
    fmi3Status fmi3Get##TYPE(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, \
                             fmi3##TYPE values[], size_t nValues)                                                       \
    {                                                                                                                   \
        return instance ? (fmi3Status)instance_get(instance, "fmi3Get" #TYPE, KIND, valueReferences, nValueReferences,  \
                                                   values, nValues)                                                     \
                        : fmi3Error;                                                                                    \
    }                                                                                                                   \
    fmi3Status fmi3Set##TYPE(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, \
                             const fmi3##TYPE values[], size_t nValues)                                                 \
    {                                                                                                                   \
        return instance ? (fmi3Status)instance_set(instance, "fmi3Set" #TYPE, KIND, valueReferences, nValueReferences,  \
                                                   values, nValues)                                                     \
                        : fmi3Error;                                                                                    \
    }

ACCESS(Float32, FLOAT32)
ACCESS(Float64, FLOAT64)
ACCESS(Int32, INT32)
ACCESS(Int64, ENUMERATION)
ACCESS(UInt64, UINT64)
ACCESS(Boolean, BOOLEAN)

static fmi3Status no_such_type(Instance *instance, const char *call, size_t count)
{
    if (!instance) {
        return fmi3Error;
    }
    return count ? (fmi3Status)instance_refuse(instance, call, "the unit has no variables of this type") : fmi3OK;
}

/* A type of which no unit has a variable. */
#define NO_ACCESS(TYPE)                                                                                                 \
    fmi3Status fmi3Get##TYPE(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, \
                             fmi3##TYPE values[], size_t nValues)                                                       \
    {                                                                                                                   \
        (void)valueReferences;                                                                                          \
        (void)values;                                                                                                   \
        (void)nValues;                                                                                                  \
        return no_such_type(instance, "fmi3Get" #TYPE, nValueReferences);                                               \
    }                                                                                                                   \
    fmi3Status fmi3Set##TYPE(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, \
                             const fmi3##TYPE values[], size_t nValues)                                                 \
    {                                                                                                                   \
        (void)valueReferences;                                                                                          \
        (void)values;                                                                                                   \
        (void)nValues;                                                                                                  \
        return no_such_type(instance, "fmi3Set" #TYPE, nValueReferences);                                               \
    }

NO_ACCESS(Int8)
NO_ACCESS(UInt8)
NO_ACCESS(Int16)
NO_ACCESS(UInt16)
NO_ACCESS(UInt32)
NO_ACCESS(String)

/* Of Binary variables all are computed by the unit. */
fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         size_t valueSizes[], fmi3Binary values[], size_t nValues)
{
    return instance ? (fmi3Status)instance_get_binary(instance, "fmi3GetBinary", valueReferences, nValueReferences, valueSizes,
                                                      values, nValues)
                    : fmi3Error;
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         const size_t valueSizes[], const fmi3Binary values[], size_t nValues)
{
    (void)valueSizes;
    (void)nValues;
    return instance ? (fmi3Status)instance_set_binary(instance, "fmi3SetBinary", valueReferences, nValueReferences, values)
                    : fmi3Error;
}
