/* runner.h: time, samples and messages of an FMU, the same for FMI 2.0 and 3.0.
 *
 * The law runs at start + k T, k = 0, 1, ...; its outputs are held until the next sample.  A
 * communication step from t to t + h runs the samples with t <= start + k T < t + h, with the
 * inputs that were set for the step.
 *
 * model.h has the parts that differ from FMU to FMU.
 */
#ifndef RUNNER_H
#define RUNNER_H

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model.h"

#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORTED __attribute__((visibility("default")))
#else
#define EXPORTED
#endif

/* For names that begin with a prefix. */
#define JOIN(PREFIX, NAME) PREFIX##NAME
#define JOINED(PREFIX, NAME) JOIN(PREFIX, NAME)

/* The numbers of FMI 2.0 and 3.0. */
enum { RUN_OK = 0, RUN_WARNING = 1, RUN_DISCARD = 2, RUN_ERROR = 3 };
enum { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED };
enum { MESSAGE_SIZE = 400 };

/* Two times are equal if they differ by less than this share of the sample time. */
static const double SLACK = 1e-6;
static const double MOST_SAMPLES = 1e9; /* of one communication step */

/* The state between calls. It has no pointer, so it can be copied byte by byte. */
typedef struct snapshot {
    char token[sizeof MODEL_TOKEN];
    int mode;
    unsigned told;  /* status bits that were logged: each is logged once */
    double start;   /* s, of the first sample */
    double time;    /* s, the communication point */
    double samples; /* number of samples so far */
    model model;
} snapshot;

static int run_says(char *say, int status, const char *text)
{
    (void)snprintf(say, MESSAGE_SIZE, "%s", text);
    return status;
}

static void run_reset(snapshot *now)
{
    memset(now, 0, sizeof *now);
    memcpy(now->token, MODEL_TOKEN, sizeof MODEL_TOKEN);
    memcpy(now->model.real, model_start, sizeof model_start);
    now->mode = INSTANTIATED;
}

static int run_get(const snapshot *now, size_t place, double *value)
{
    if (place >= MODEL_REALS) {
        return 0;
    }
    *value = place == MODEL_TIME ? now->time : now->model.real[place];
    return 1;
}

static int run_set(snapshot *now, size_t place, double value)
{
    const int early = now->mode == INSTANTIATED || now->mode == INITIALIZING;
    if (place >= MODEL_REALS) {
        return 0;
    }
    if (!(model_kind[place] == MODEL_INPUT && (early || now->mode == STEPPING))
        && !(model_kind[place] == MODEL_PARAMETER && early)) {
        return 0;
    }
    now->model.real[place] = value;
    return 1;
}

/* The outputs at the start, from a copy of the state: the first step runs the first sample. */
static void run_preview(snapshot *now)
{
    model trial = now->model;
    if (model_prepare(&trial) == NULL) {
        (void)model_sample(&trial);
        memcpy(now->model.real, trial.real, sizeof trial.real);
        now->model.status = trial.status;
    }
}

static int run_enter(snapshot *now, double start, char *say)
{
    if (now->mode != INSTANTIATED) {
        return run_says(say, RUN_ERROR, "initialization was entered twice, or too late");
    }
    if (!isfinite(start)) {
        return run_says(say, RUN_ERROR, "the start time is not finite");
    }
    now->start = now->time = start;
    now->mode = INITIALIZING;
    return RUN_OK;
}

static int run_exit(snapshot *now, char *say)
{
    double time;
    const char *wrong;
    if (now->mode != INITIALIZING) {
        return run_says(say, RUN_ERROR, "initialization was not entered");
    }
    wrong = model_prepare(&now->model);
    if (wrong != NULL) {
        return run_says(say, RUN_ERROR, wrong);
    }
    time = model_sample_time(&now->model);
    if (!(now->start + SLACK * time > now->start)) {
        return run_says(say, RUN_ERROR, "the sample time is too small for the start time");
    }
    run_preview(now);
    now->mode = STEPPING;
    return RUN_OK;
}

static int run_terminate(snapshot *now, char *say)
{
    if (now->mode != STEPPING) {
        return run_says(say, RUN_ERROR, "there is nothing to terminate: no step can be done");
    }
    now->mode = TERMINATED;
    return RUN_OK;
}

/* Report each status bit once, but for those of normal operation. */
static int run_warns(snapshot *now, unsigned status, char *say)
{
    const unsigned fresh = status & ~now->told & ~(unsigned)MODEL_NORMAL;
    unsigned bit;
    size_t used = 0;
    if (fresh == 0u) {
        return RUN_OK;
    }
    now->told |= fresh;
    for (bit = 1u; bit != 0u && bit <= fresh; bit <<= 1) {
        if ((fresh & bit) != 0u && used < MESSAGE_SIZE - 1) {
            const int count = snprintf(say + used, MESSAGE_SIZE - used, "%s%s", used > 0 ? "; " : "",
                                       model_message(bit));
            used += count > 0 ? (size_t)count : 0u;
        }
    }
    return RUN_WARNING;
}

static int run_step(snapshot *now, double at, double step, char *say)
{
    const double time = model_sample_time(&now->model);
    const double end = at + step;
    const double slack = SLACK * time;
    unsigned status = 0u;
    int ran = 0;
    if (now->mode != STEPPING) {
        return run_says(say, RUN_ERROR,
                        "a step was asked for before initialization has ended, or after the end");
    }
    if (!(step > 0.0) || !isfinite(at) || !isfinite(end) || !(end > at)) {
        (void)snprintf(say, MESSAGE_SIZE, "a step of %.9g s from %.9g s was asked for; it must be "
                       "above 0 and finite; nothing was done", step, at);
        return RUN_ERROR;
    }
    if (fabs(at - now->time) > slack + 8.0 * DBL_EPSILON * fabs(at)) {
        (void)snprintf(say, MESSAGE_SIZE, "the step starts at %.9g s, but the last one ended at "
                       "%.9g s: time goes backwards or jumps; nothing was done", at, now->time);
        return RUN_ERROR;
    }
    if (step > MOST_SAMPLES * time || !(end + slack > end)) {
        (void)snprintf(say, MESSAGE_SIZE, "a step of %.9g s to %.9g s cannot be cut in samples of "
                       "%.9g s; nothing was done", step, end, time);
        return RUN_ERROR;
    }
    while (now->start + now->samples * time < end - slack) {
        status |= model_sample(&now->model);
        now->samples += 1.0;
        ran = 1;
    }
    now->time = end;
    if (ran) {
        now->model.status = status;
    }
    return run_warns(now, status, say);
}

/* A snapshot as bytes: the state and its checksum (FNV-1a), which shows damage. */
enum { STORED_SIZE = sizeof(snapshot) + 8 };

static void run_sum(const unsigned char *bytes, unsigned char *sum)
{
    unsigned long long found = 14695981039346656037ULL;
    size_t k;
    for (k = 0; k < sizeof(snapshot); k++) {
        found = (found ^ bytes[k]) * 1099511628211ULL;
    }
    for (k = 0; k < 8; k++) {
        sum[k] = (unsigned char)(found >> (8 * k) & 255u);
    }
}

static void run_store(const void *state, void *bytes)
{
    memcpy(bytes, state, sizeof(snapshot));
    run_sum(bytes, (unsigned char *)bytes + sizeof(snapshot));
}

/* Whether bytes are a snapshot of this model, as it was stored. */
static int run_fits(const void *bytes, size_t size)
{
    unsigned char sum[8];
    if (size != STORED_SIZE
        || memcmp((const char *)bytes + offsetof(snapshot, token), MODEL_TOKEN, sizeof MODEL_TOKEN)
            != 0) {
        return 0;
    }
    run_sum(bytes, sum);
    return memcmp((const char *)bytes + sizeof(snapshot), sum, sizeof sum) == 0;
}

#endif
