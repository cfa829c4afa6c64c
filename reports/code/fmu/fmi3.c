/* fmi3.c: the functions of FMI 3.0 for co-simulation.
 *
 * Types and functions are those of the standard (fmi-standard.org/docs/3.0).  No function for model
 * exchange, scheduled execution, clocks or derivatives is supported; each returns an error.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "runner.h"

/* Linked statically, the names begin with FMI3_FUNCTION_PREFIX. */
#ifdef FMI3_FUNCTION_PREFIX
#define FMI(NAME) JOINED(FMI3_FUNCTION_PREFIX, fmi3##NAME)
#else
#define FMI(NAME) fmi3##NAME
#endif

typedef int Status; /* fmi3OK 0, fmi3Warning 1, fmi3Discard 2, fmi3Error 3, fmi3Fatal 4 */
typedef void *Environment;
typedef uint32_t Reference;
typedef void (*LogMessage)(Environment environment, Status status, const char *category,
                           const char *message);

typedef struct instance {
    snapshot now;
    Environment environment;
    LogMessage log;
} instance;

static Status told(const instance *one, Status status, const char *message)
{
    if (status != RUN_OK && one->log != NULL) {
        one->log(one->environment, status,
                 status == RUN_WARNING ? "logStatusWarning" : "logStatusError", message);
    }
    return status;
}

static Status unsupported(void *given)
{
    return given == NULL ? RUN_ERROR
                         : told(given, RUN_ERROR, "this function is not supported by the model");
}

EXPORTED const char *FMI(GetVersion)(void)
{
    return "3.0";
}

EXPORTED Status FMI(SetDebugLogging)(void *given, bool on, size_t count, const char *const names[])
{
    (void)on;
    (void)count;
    (void)names;
    return given == NULL ? RUN_ERROR : RUN_OK; /* warnings and errors are always reported */
}

EXPORTED void *FMI(InstantiateCoSimulation)(const char *name, const char *token,
    const char *resources, bool visible, bool logging, bool events, bool early,
    const Reference between[], size_t count, Environment environment, LogMessage log, void *update)
{
    instance *one;
    (void)name;
    (void)resources;
    (void)visible;
    (void)logging;
    (void)early;
    (void)between;
    (void)update;
    if (token == NULL || strcmp(token, MODEL_TOKEN) != 0) {
        if (log != NULL) {
            log(environment, RUN_ERROR, "logStatusError",
                "the instantiation token is not this model's");
        }
        return NULL;
    }
    if (events || count > 0) {
        if (log != NULL) {
            log(environment, RUN_ERROR, "logStatusError",
                "the model has no event mode and no intermediate update");
        }
        return NULL;
    }
    one = calloc(1, sizeof *one);
    if (one != NULL) {
        run_reset(&one->now);
        one->environment = environment;
        one->log = log;
    }
    return one;
}

EXPORTED void *FMI(InstantiateModelExchange)(const char *name, const char *token,
    const char *resources, bool visible, bool logging, Environment environment, LogMessage log)
{
    (void)name;
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    if (log != NULL) {
        log(environment, RUN_ERROR, "logStatusError", "the model is for co-simulation alone");
    }
    return NULL;
}

EXPORTED void *FMI(InstantiateScheduledExecution)(const char *name, const char *token,
    const char *resources, bool visible, bool logging, Environment environment, LogMessage log,
    void *update, void *lock, void *unlock)
{
    (void)update;
    (void)lock;
    (void)unlock;
    return FMI(InstantiateModelExchange)(name, token, resources, visible, logging, environment, log);
}

EXPORTED void FMI(FreeInstance)(void *given)
{
    free(given);
}

EXPORTED Status FMI(EnterInitializationMode)(void *given, bool tolerant, double tolerance,
    double start, bool ends, double stop)
{
    char say[MESSAGE_SIZE];
    instance *one = given;
    (void)tolerant;
    (void)tolerance;
    (void)ends;
    (void)stop;
    return given == NULL ? RUN_ERROR : told(one, run_enter(&one->now, start, say), say);
}

EXPORTED Status FMI(ExitInitializationMode)(void *given)
{
    char say[MESSAGE_SIZE];
    instance *one = given;
    return given == NULL ? RUN_ERROR : told(one, run_exit(&one->now, say), say);
}

EXPORTED Status FMI(Terminate)(void *given)
{
    char say[MESSAGE_SIZE];
    instance *one = given;
    return given == NULL ? RUN_ERROR : told(one, run_terminate(&one->now, say), say);
}

EXPORTED Status FMI(Reset)(void *given)
{
    if (given == NULL) {
        return RUN_ERROR;
    }
    run_reset(&((instance *)given)->now);
    return RUN_OK;
}

EXPORTED Status FMI(GetFloat64)(void *given, const Reference references[], size_t count,
    double values[], size_t size)
{
    instance *one = given;
    size_t k;
    if (given == NULL || count != size) {
        return RUN_ERROR;
    }
    if (one->now.mode == INITIALIZING) {
        run_preview(&one->now);
    }
    for (k = 0; k < count; k++) {
        if (!run_get(&one->now, references[k], &values[k])) {
            return told(one, RUN_ERROR, "there is no Float64 with this value reference");
        }
    }
    return RUN_OK;
}

EXPORTED Status FMI(SetFloat64)(void *given, const Reference references[], size_t count,
    const double values[], size_t size)
{
    instance *one = given;
    size_t k;
    if (given == NULL || count != size) {
        return RUN_ERROR;
    }
    for (k = 0; k < count; k++) {
        if (!run_set(&one->now, references[k], values[k])) {
            return told(one, RUN_ERROR,
                        "no Float64 with this value reference can be set now");
        }
    }
    return RUN_OK;
}

EXPORTED Status FMI(GetUInt32)(void *given, const Reference references[], size_t count,
    uint32_t values[], size_t size)
{
    instance *one = given;
    size_t k;
    if (given == NULL || count != size) {
        return RUN_ERROR;
    }
    for (k = 0; k < count; k++) {
        if (references[k] != MODEL_STATUS) {
            return told(one, RUN_ERROR, "there is no UInt32 with this value reference");
        }
        values[k] = (uint32_t)one->now.model.status;
    }
    return RUN_OK;
}

EXPORTED Status FMI(DoStep)(void *given, double at, double step, bool no_return, bool *event,
    bool *terminate, bool *early, double *last)
{
    char say[MESSAGE_SIZE];
    instance *one = given;
    Status status;
    (void)no_return;
    if (given == NULL) {
        return RUN_ERROR;
    }
    status = run_step(&one->now, at, step, say);
    if (event != NULL) {
        *event = false;
    }
    if (terminate != NULL) {
        *terminate = false;
    }
    if (early != NULL) {
        *early = false;
    }
    if (last != NULL) {
        *last = one->now.time;
    }
    return told(one, status, say);
}

EXPORTED Status FMI(GetFMUState)(void *given, void **state)
{
    if (given == NULL || state == NULL) {
        return RUN_ERROR;
    }
    if (*state == NULL) {
        *state = malloc(sizeof(snapshot));
    }
    if (*state == NULL) {
        return told(given, RUN_ERROR, "no memory is left");
    }
    memcpy(*state, &((instance *)given)->now, sizeof(snapshot));
    return RUN_OK;
}

EXPORTED Status FMI(SetFMUState)(void *given, void *state)
{
    if (given == NULL || state == NULL) {
        return RUN_ERROR;
    }
    memcpy(&((instance *)given)->now, state, sizeof(snapshot));
    return RUN_OK;
}

EXPORTED Status FMI(FreeFMUState)(void *given, void **state)
{
    (void)given;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return RUN_OK;
}

EXPORTED Status FMI(SerializedFMUStateSize)(void *given, void *state, size_t *size)
{
    if (given == NULL || state == NULL || size == NULL) {
        return RUN_ERROR;
    }
    *size = STORED_SIZE;
    return RUN_OK;
}

EXPORTED Status FMI(SerializeFMUState)(void *given, void *state, uint8_t bytes[], size_t size)
{
    if (given == NULL || state == NULL || bytes == NULL || size < STORED_SIZE) {
        return RUN_ERROR;
    }
    run_store(state, bytes);
    return RUN_OK;
}

EXPORTED Status FMI(DeserializeFMUState)(void *given, const uint8_t bytes[], size_t size,
    void **state)
{
    if (given == NULL || bytes == NULL || state == NULL) {
        return RUN_ERROR;
    }
    if (!run_fits(bytes, size)) {
        return told(given, RUN_ERROR, "the stored state is not one of this model");
    }
    if (*state == NULL) {
        *state = malloc(sizeof(snapshot));
    }
    if (*state == NULL) {
        return told(given, RUN_ERROR, "no memory is left");
    }
    memcpy(*state, bytes, sizeof(snapshot));
    return RUN_OK;
}

/* Variables of these types do not exist: none can be read or set. */
#define NO_VARIABLES(TYPE, KIND)                                                                   \
    EXPORTED Status FMI(Get##TYPE)(void *given, const Reference references[], size_t count,         \
                                  KIND values[], size_t size)                                      \
    {                                                                                              \
        (void)references;                                                                          \
        (void)values;                                                                              \
        (void)size;                                                                                \
        return count == 0 ? RUN_OK : unsupported(given);                                           \
    }                                                                                              \
    NO_SETTER(TYPE, KIND)
#define NO_SETTER(TYPE, KIND)                                                                      \
    EXPORTED Status FMI(Set##TYPE)(void *given, const Reference references[], size_t count,         \
                                  const KIND values[], size_t size)                                \
    {                                                                                              \
        (void)references;                                                                          \
        (void)values;                                                                              \
        (void)size;                                                                                \
        return count == 0 ? RUN_OK : unsupported(given);                                           \
    }
typedef const char *Text;
NO_VARIABLES(Float32, float)
NO_VARIABLES(Int8, int8_t)
NO_VARIABLES(UInt8, uint8_t)
NO_VARIABLES(Int16, int16_t)
NO_VARIABLES(UInt16, uint16_t)
NO_VARIABLES(Int32, int32_t)
NO_SETTER(UInt32, uint32_t)
NO_VARIABLES(Int64, int64_t)
NO_VARIABLES(UInt64, uint64_t)
NO_VARIABLES(Boolean, bool)
NO_VARIABLES(String, Text)

/* Functions that are not supported: the arguments are ignored. */
#define UNSUPPORTED(NAME, ...)                                                                     \
    EXPORTED Status NAME(void *given, __VA_ARGS__);                                                \
    EXPORTED Status NAME(void *given, __VA_ARGS__)
#define SAYS_NO { return unsupported(given); }
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
typedef const Reference *References;
UNSUPPORTED(FMI(GetBinary), References r, size_t n, size_t s[], const uint8_t *v[], size_t m) SAYS_NO
UNSUPPORTED(FMI(SetBinary), References r, size_t n, const size_t s[], const uint8_t *const v[],
            size_t m) SAYS_NO
UNSUPPORTED(FMI(GetClock), References r, size_t n, bool v[]) SAYS_NO
UNSUPPORTED(FMI(SetClock), References r, size_t n, const bool v[]) SAYS_NO
UNSUPPORTED(FMI(GetNumberOfVariableDependencies), Reference r, size_t *n) SAYS_NO
UNSUPPORTED(FMI(GetVariableDependencies), Reference r, size_t a[], Reference b[], size_t c[],
            int kinds[], size_t n) SAYS_NO
UNSUPPORTED(FMI(GetDirectionalDerivative), References u, size_t n, References k, size_t m,
            const double seed[], size_t s, double found[], size_t f) SAYS_NO
UNSUPPORTED(FMI(GetAdjointDerivative), References u, size_t n, References k, size_t m,
            const double seed[], size_t s, double found[], size_t f) SAYS_NO
UNSUPPORTED(FMI(GetIntervalDecimal), References r, size_t n, double v[], int kinds[]) SAYS_NO
UNSUPPORTED(FMI(GetIntervalFraction), References r, size_t n, uint64_t a[], uint64_t b[],
            int kinds[]) SAYS_NO
UNSUPPORTED(FMI(GetShiftDecimal), References r, size_t n, double v[]) SAYS_NO
UNSUPPORTED(FMI(GetShiftFraction), References r, size_t n, uint64_t a[], uint64_t b[]) SAYS_NO
UNSUPPORTED(FMI(SetIntervalDecimal), References r, size_t n, const double v[]) SAYS_NO
UNSUPPORTED(FMI(SetIntervalFraction), References r, size_t n, const uint64_t a[],
            const uint64_t b[]) SAYS_NO
UNSUPPORTED(FMI(SetShiftDecimal), References r, size_t n, const double v[]) SAYS_NO
UNSUPPORTED(FMI(SetShiftFraction), References r, size_t n, const uint64_t a[],
            const uint64_t b[]) SAYS_NO
UNSUPPORTED(FMI(UpdateDiscreteStates), bool *a, bool *b, bool *c, bool *d, bool *e, double *t)
    SAYS_NO
UNSUPPORTED(FMI(CompletedIntegratorStep), bool a, bool *b, bool *c) SAYS_NO
UNSUPPORTED(FMI(SetTime), double t) SAYS_NO
UNSUPPORTED(FMI(SetContinuousStates), const double x[], size_t n) SAYS_NO
UNSUPPORTED(FMI(GetContinuousStateDerivatives), double x[], size_t n) SAYS_NO
UNSUPPORTED(FMI(GetEventIndicators), double x[], size_t n) SAYS_NO
UNSUPPORTED(FMI(GetContinuousStates), double x[], size_t n) SAYS_NO
UNSUPPORTED(FMI(GetNominalsOfContinuousStates), double x[], size_t n) SAYS_NO
UNSUPPORTED(FMI(GetNumberOfEventIndicators), size_t *n) SAYS_NO
UNSUPPORTED(FMI(GetNumberOfContinuousStates), size_t *n) SAYS_NO
UNSUPPORTED(FMI(GetOutputDerivatives), References r, size_t n, const int32_t orders[],
            double v[], size_t m) SAYS_NO
UNSUPPORTED(FMI(ActivateModelPartition), Reference r, double t) SAYS_NO

#define NO_MODE(NAME)                                                                              \
    EXPORTED Status NAME(void *given)                                                              \
    {                                                                                              \
        return unsupported(given);                                                                 \
    }
NO_MODE(FMI(EnterEventMode))
NO_MODE(FMI(EnterConfigurationMode))
NO_MODE(FMI(ExitConfigurationMode))
NO_MODE(FMI(EvaluateDiscreteStates))
NO_MODE(FMI(EnterContinuousTimeMode))
NO_MODE(FMI(EnterStepMode))
