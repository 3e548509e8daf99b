/* Saved states: one block of memory without pointers, so that every operation is a copy. */
#include "instance.h"

#include <stdlib.h>
#include <string.h>

enum { SAVED_STATE_VERSION = 1 };

struct SavedState {
    char magic[8];
    uint64_t version;
    uint64_t size;     /* of all, bytes */
    uint64_t token;    /* checksum of the instantiation token: the unit and its build */
    uint64_t checksum; /* of all that follows */
    uint64_t kind;
    uint64_t mode;
    double start_time, stop_time, last_time;
    char values[];
};

static const char saved_state_magic[8] = {'U', 'l', 'n', 'a', 'S', 't', 'a', 't'};

/* FNV-1a, 64 bits */
static uint64_t checksum_of(const void *bytes, size_t size)
{
    const unsigned char *next = bytes;
    uint64_t sum = 14695981039346656037ULL;
    for (size_t i = 0; i < size; i++) {
        sum = (sum ^ next[i]) * 1099511628211ULL;
    }
    return sum;
}

static size_t instance_saved_size(const SavedState *saved)
{
    return (size_t)saved->size;
}

static uint64_t content_checksum(const SavedState *saved)
{
    size_t head = offsetof(SavedState, kind);
    return checksum_of((const char *)saved + head, instance_saved_size(saved) - head);
}

/* A state to be written over, or a new one. */
static SavedState *state_of_size(SavedState *saved, size_t size)
{
    bool fits = saved && saved->size == size;
    return fits ? saved : realloc(saved, size);
}

static Status instance_save(Instance *instance, SavedState **saved)
{
    size_t size = values_size(instance->values);
    SavedState *state = state_of_size(*saved, sizeof *state + size);
    if (!state) {
        return report(&instance->log, STATUS_ERROR, "out of memory: %zu bytes for a state", sizeof *state + size);
    }
    *state = (SavedState){.size = sizeof *state + size};
    memcpy(state->magic, saved_state_magic, sizeof state->magic);
    state->version = SAVED_STATE_VERSION;
    state->token = checksum_of(unit.token, strlen(unit.token));
    state->kind = (uint64_t)instance->kind;
    state->mode = (uint64_t)instance->mode;
    state->start_time = instance->start_time;
    state->stop_time = instance->stop_time;
    state->last_time = instance->last_time;
    memcpy(state->values, instance->values, size);
    *saved = state;
    return STATUS_OK;
}

static Status refuse_state(Instance *instance, const char *reason)
{
    return report(&instance->log, STATUS_ERROR, "the state is refused: %s", reason);
}

static Status check_state(Instance *instance, const SavedState *saved)
{
    if (memcmp(saved->magic, saved_state_magic, sizeof saved->magic) != 0) {
        return refuse_state(instance, "it is not a saved state of an Ulna unit");
    }
    if (saved->version != SAVED_STATE_VERSION) {
        return refuse_state(instance, "its version is another");
    }
    if (saved->token != checksum_of(unit.token, strlen(unit.token))) {
        return refuse_state(instance, "it comes from another unit, or another build of this one");
    }
    if (saved->kind != (uint64_t)instance->kind) {
        return refuse_state(instance, "it comes from an instance of the other kind (co-simulation, model exchange)");
    }
    return STATUS_OK;
}

static bool same_parameters(const char *a, const char *b)
{
    for (size_t i = 0; i < unit.variable_count; i++) {
        const Variable *variable = &unit.variables[i];
        bool parameter = variable->causality == PARAMETER || variable->causality == STRUCTURAL_PARAMETER;
        if (parameter && memcmp(a + variable->offset, b + variable->offset, variable->count * element_size[variable->type])) {
            return false;
        }
    }
    return true;
}

static Status instance_restore(Instance *instance, const SavedState *saved)
{
    Status status = check_state(instance, saved);
    if (status != STATUS_OK) {
        return status;
    }
    size_t size = saved->size - sizeof *saved;
    status = instance_fit_values(instance, size);
    if (status != STATUS_OK) {
        return status;
    }
    instance->unprepared |= !same_parameters(instance->values, saved->values);
    memcpy(instance->values, saved->values, size);
    instance->mode = (Mode)saved->mode;
    instance->start_time = saved->start_time;
    instance->stop_time = saved->stop_time;
    instance->last_time = saved->last_time;
    instance_touch(instance);
    /* here, since a step must not allocate */
    return instance->mode & (EVENT | CONTINUOUS_TIME | STEP) ? instance_prepare(instance) : STATUS_OK;
}

static Status refuse_size(Instance *instance, size_t size, size_t needed)
{
    return report(&instance->log, STATUS_ERROR, "the state is refused: it has %zu bytes; needed: %zu", size, needed);
}

static Status instance_serialize(Instance *instance, const SavedState *saved, void *bytes, size_t size)
{
    size_t needed = instance_saved_size(saved);
    if (size < needed) {
        return report(&instance->log, STATUS_ERROR, "the array for a serialized state has %zu bytes; needed: %zu", size,
                      needed);
    }
    Status status = check_state(instance, saved);
    if (status == STATUS_OK) {
        SavedState head = *saved;
        head.checksum = content_checksum(saved);
        memcpy(bytes, saved, needed);
        memcpy(bytes, &head, sizeof head);
    }
    return status;
}

/* The bytes may be anybody's: nothing in them counts before the checksum does. */
static Status check_bytes(Instance *instance, const SavedState *state, size_t size)
{
    Status status = check_state(instance, state);
    if (status == STATUS_OK && state->size != size) {
        status = refuse_size(instance, size, instance_saved_size(state));
    }
    if (status == STATUS_OK && state->checksum != content_checksum(state)) {
        status = refuse_state(instance, "its checksum does not fit its content: it was damaged");
    }
    if (status == STATUS_OK && sizeof *state + values_size(state->values) != size) {
        status = refuse_state(instance, "it has another size than its structural parameters ask for");
    }
    return status;
}

static Status instance_deserialize(Instance *instance, const void *bytes, size_t size, SavedState **saved)
{
    size_t least = sizeof(SavedState) + unit.size;
    if (unit.array ? size < least : size != least) {
        return refuse_size(instance, size, least);
    }
    SavedState *state = malloc(size);
    if (!state) {
        return report(&instance->log, STATUS_ERROR, "out of memory: %zu bytes for a state", size);
    }
    memcpy(state, bytes, size);
    Status status = check_bytes(instance, state, size);
    if (status != STATUS_OK) {
        free(state);
        return status;
    }
    *saved = state;
    return STATUS_OK;
}
