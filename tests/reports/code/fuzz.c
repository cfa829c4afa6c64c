/* Calls a law with random bytes: inputs, sample times, and now and then a damaged state.
 * W and the header are given by -DW=word -DHEADER="word.h"; with libFuzzer define LIBFUZZER. */
#include HEADER

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define JOIN2(a, b) a##b
#define JOIN(a, b) JOIN2(a, b)
#define F(name) JOIN(W, name)

typedef F(_real) real;

static F(_state) state;

/* One call from bytes: the first says what is done, the others are its values. */
static void one(const uint8_t *bytes, size_t count)
{
    union {
        F(_outputs) values;
        real each[sizeof(F(_outputs)) / sizeof(real)];
    } out;
    union {
        F(_inputs) values;
        real each[sizeof(F(_inputs)) / sizeof(real)];
    } in;
    real time = (real)0.01;
    size_t k;
    unsigned status;
    memset(&in, 0, sizeof in);
    memset(&out, 0xFF, sizeof out);
    if (count < 1) {
        return;
    }
    if (bytes[0] < 8 && count > sizeof time) {
        memcpy(&time, bytes + 1, sizeof time);
        status = bytes[0] < 4 ? F(_init)(&state, time) : F(_set_sample_time)(&state, time);
        (void)F(_message)(status);
        return;
    }
    if (bytes[0] == 8) {
        memcpy(&state, bytes + 1, count - 1 < sizeof state ? count - 1 : sizeof state);
    } else {
        memcpy(&in, bytes + 1, count - 1 < sizeof in ? count - 1 : sizeof in);
    }
    status = F(_step)(&state, &in.values, &out.values);
    for (k = 0; k < sizeof out / sizeof(real); k++) {
        if (!isfinite(out.each[k])) {
            printf("output %d is not finite, status %u\n", (int)k, status);
            abort();
        }
    }
    (void)F(_message)(status);
}

#ifdef LIBFUZZER
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t count);
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t count)
{
    const size_t most = 1 + sizeof(F(_inputs));
    memset(&state, 0, sizeof state);
    while (count > 0) {
        const size_t now = count < most ? count : most;
        one(bytes, now);
        bytes += now;
        count -= now;
    }
    return 0;
}
#else
static uint64_t seed = 0x9E3779B97F4A7C15u;

static uint64_t random_bits(void)
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return seed;
}

int main(int count, char **arguments)
{
    const long calls = count > 1 ? strtol(arguments[1], NULL, 10) : 1000;
    union {
        uint8_t bytes[1 + sizeof(state) + sizeof(real)];
        F(_state) room;
    } given;
    real value;
    long k;
    for (k = 0; k < calls; k++) {
        size_t j;
        const uint64_t kind = random_bits() % 8;
        given.bytes[0] = (uint8_t)random_bits();
        if (given.bytes[0] < 9 && random_bits() % 16 != 0) {
            given.bytes[0] = 9;
        }
        for (j = 1; j + sizeof value <= sizeof given.bytes; j += sizeof value) {
            const uint64_t bits = random_bits();
            const real size = (real)((double)(bits >> 11) / 9007199254740992.0 * 2.0 - 1.0);
            if (kind == 0) { /* any bits: NaN, infinite, smallest, largest */
                memcpy(&value, &bits, sizeof value);
            } else if (kind == 1) {
                value = (bits & 1u) != 0u ? (real)0 : -(real)0;
            } else if (kind == 2) {
                value = size * (real)1e30;
            } else { /* what sensors say, from a hair off zero to tens */
                value = size * (real)exp2((double)(bits % 48u) - 40.0);
            }
            memcpy(given.bytes + j, &value, sizeof value);
        }
        one(given.bytes, sizeof given.bytes);
    }
    printf("%ld calls\n", calls);
    return 0;
}
#endif
