/* fmi2.c: the functions of FMI 2.0 for co-simulation.
 *
 * Types and functions are those of the standard (fmi-standard.org/docs/2.0.4).  Derivatives of
 * inputs and outputs, and steps that run in the background, are not supported.
 */
#include <stddef.h>

#include "runner.h"

/* Linked statically, the names begin with FMI2_FUNCTION_PREFIX. */
#ifdef FMI2_FUNCTION_PREFIX
#define FMI(NAME) JOINED(FMI2_FUNCTION_PREFIX, fmi2##NAME)
#else
#define FMI(NAME) fmi2##NAME
#endif

typedef int Status; /* fmi2OK 0, fmi2Warning 1, fmi2Discard 2, fmi2Error 3, fmi2Fatal 4 */
typedef int Boolean;
typedef const char *Text;
typedef void *Environment;
typedef unsigned int Reference;
typedef void (*Logger)(Environment environment, Text name, Status status, Text category,
                       Text message, ...);

typedef struct callbacks {
    Logger logger;
    void *(*allocate)(size_t count, size_t size);
    void (*release)(void *memory);
    void (*finished)(Environment environment, Status status);
    Environment environment;
} callbacks;

enum { NAME_SIZE = 100, CO_SIMULATION = 1 };

typedef struct instance {
    snapshot now;
    double start; /* s, of the experiment */
    Environment environment;
    Logger logger;
    char name[NAME_SIZE];
} instance;

static Status told(instance *one, Status status, const char *message)
{
    if (status != RUN_OK && one->logger != NULL) {
        one->logger(one->environment, one->name, status,
                    status == RUN_WARNING ? "logStatusWarning" : "logStatusError", "%s", message);
    }
    return status;
}

static Status unsupported(void *given)
{
    return given == NULL ? RUN_ERROR
                         : told(given, RUN_ERROR, "this function is not supported by the model");
}

EXPORTED const char *FMI(GetTypesPlatform)(void)
{
    return "default";
}

EXPORTED const char *FMI(GetVersion)(void)
{
    return "2.0";
}

EXPORTED Status FMI(SetDebugLogging)(void *given, Boolean on, size_t count, const Text names[])
{
    (void)on;
    (void)count;
    (void)names;
    return given == NULL ? RUN_ERROR : RUN_OK; /* warnings and errors are always reported */
}

EXPORTED void *FMI(Instantiate)(Text name, int kind, Text token, Text resources,
    const callbacks *calls, Boolean visible, Boolean logging)
{
    const char *wrong = NULL;
    instance *one;
    (void)resources;
    (void)visible;
    (void)logging;
    if (name == NULL || calls == NULL) {
        return NULL;
    }
    if (kind != CO_SIMULATION) {
        wrong = "the model is for co-simulation alone";
    } else if (token == NULL || strcmp(token, MODEL_TOKEN) != 0) {
        wrong = "the GUID is not this model's";
    }
    if (wrong != NULL) {
        if (calls->logger != NULL) {
            calls->logger(calls->environment, name, RUN_ERROR, "logStatusError", "%s", wrong);
        }
        return NULL;
    }
    one = calloc(1, sizeof *one);
    if (one != NULL) {
        run_reset(&one->now);
        one->environment = calls->environment;
        one->logger = calls->logger;
        (void)snprintf(one->name, sizeof one->name, "%s", name);
    }
    return one;
}

EXPORTED void FMI(FreeInstance)(void *given)
{
    free(given);
}

EXPORTED Status FMI(SetupExperiment)(void *given, Boolean tolerant, double tolerance, double start,
    Boolean ends, double stop)
{
    (void)tolerant;
    (void)tolerance;
    (void)ends;
    (void)stop;
    if (given == NULL) {
        return RUN_ERROR;
    }
    ((instance *)given)->start = start;
    return RUN_OK;
}

EXPORTED Status FMI(EnterInitializationMode)(void *given)
{
    char say[MESSAGE_SIZE];
    instance *one = given;
    return given == NULL ? RUN_ERROR : told(one, run_enter(&one->now, one->start, say), say);
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

EXPORTED Status FMI(GetReal)(void *given, const Reference references[], size_t count,
    double values[])
{
    instance *one = given;
    size_t k;
    if (given == NULL) {
        return RUN_ERROR;
    }
    if (one->now.mode == INITIALIZING) {
        run_preview(&one->now);
    }
    for (k = 0; k < count; k++) {
        if (!run_get(&one->now, references[k], &values[k])) {
            return told(one, RUN_ERROR, "there is no Real with this value reference");
        }
    }
    return RUN_OK;
}

EXPORTED Status FMI(SetReal)(void *given, const Reference references[], size_t count,
    const double values[])
{
    instance *one = given;
    size_t k;
    if (given == NULL) {
        return RUN_ERROR;
    }
    for (k = 0; k < count; k++) {
        if (!run_set(&one->now, references[k], values[k])) {
            return told(one, RUN_ERROR, "no Real with this value reference can be set now");
        }
    }
    return RUN_OK;
}

EXPORTED Status FMI(GetInteger)(void *given, const Reference references[], size_t count,
    int values[])
{
    instance *one = given;
    size_t k;
    if (given == NULL) {
        return RUN_ERROR;
    }
    for (k = 0; k < count; k++) {
        if (references[k] != MODEL_STATUS) {
            return told(one, RUN_ERROR, "there is no Integer with this value reference");
        }
        values[k] = (int)one->now.model.status;
    }
    return RUN_OK;
}

EXPORTED Status FMI(DoStep)(void *given, double at, double step, Boolean no_return)
{
    char say[MESSAGE_SIZE];
    instance *one = given;
    (void)no_return;
    return given == NULL ? RUN_ERROR : told(one, run_step(&one->now, at, step, say), say);
}

EXPORTED Status FMI(CancelStep)(void *given)
{
    return unsupported(given); /* no step runs in the background */
}

EXPORTED Status FMI(GetFMUstate)(void *given, void **state)
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

EXPORTED Status FMI(SetFMUstate)(void *given, void *state)
{
    if (given == NULL || state == NULL) {
        return RUN_ERROR;
    }
    memcpy(&((instance *)given)->now, state, sizeof(snapshot));
    return RUN_OK;
}

EXPORTED Status FMI(FreeFMUstate)(void *given, void **state)
{
    (void)given;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return RUN_OK;
}

EXPORTED Status FMI(SerializedFMUstateSize)(void *given, void *state, size_t *size)
{
    if (given == NULL || state == NULL || size == NULL) {
        return RUN_ERROR;
    }
    *size = STORED_SIZE;
    return RUN_OK;
}

EXPORTED Status FMI(SerializeFMUstate)(void *given, void *state, char bytes[], size_t size)
{
    if (given == NULL || state == NULL || bytes == NULL || size < STORED_SIZE) {
        return RUN_ERROR;
    }
    run_store(state, bytes);
    return RUN_OK;
}

EXPORTED Status FMI(DeSerializeFMUstate)(void *given, const char bytes[], size_t size, void **state)
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
#define NONE(NAME, KIND)                                                                           \
    EXPORTED Status NAME(void *given, const Reference references[], size_t count, KIND values[])   \
    {                                                                                              \
        (void)references;                                                                          \
        (void)values;                                                                              \
        return count == 0 ? RUN_OK : unsupported(given);                                           \
    }
NONE(FMI(GetBoolean), Boolean)
NONE(FMI(GetString), Text)
NONE(FMI(SetInteger), const int)
NONE(FMI(SetBoolean), const Boolean)
NONE(FMI(SetString), const Text)

#define NO_ORDERS(NAME, KIND)                                                                      \
    EXPORTED Status NAME(void *given, const Reference references[], size_t count,                  \
                         const int orders[], KIND values[])                                        \
    {                                                                                              \
        (void)references;                                                                          \
        (void)orders;                                                                              \
        (void)values;                                                                              \
        return count == 0 ? RUN_OK : unsupported(given);                                           \
    }
NO_ORDERS(FMI(SetRealInputDerivatives), const double)
NO_ORDERS(FMI(GetRealOutputDerivatives), double)

/* There is no status of a step that runs in the background. */
#define NO_STATUS(NAME, KIND)                                                                      \
    EXPORTED Status NAME(void *given, int what, KIND *value)                                       \
    {                                                                                              \
        (void)what;                                                                                \
        (void)value;                                                                               \
        return given == NULL ? RUN_ERROR : RUN_DISCARD;                                            \
    }
NO_STATUS(FMI(GetStatus), Status)
NO_STATUS(FMI(GetRealStatus), double)
NO_STATUS(FMI(GetIntegerStatus), int)
NO_STATUS(FMI(GetBooleanStatus), Boolean)
NO_STATUS(FMI(GetStringStatus), Text)

EXPORTED Status FMI(GetDirectionalDerivative)(void *given, const Reference unknowns[], size_t count,
    const Reference knowns[], size_t size, const double seed[], double found[])
{
    (void)unknowns;
    (void)count;
    (void)knowns;
    (void)size;
    (void)seed;
    (void)found;
    return unsupported(given);
}
