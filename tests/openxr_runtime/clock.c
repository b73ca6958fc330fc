/* The machine's monotonic clock, and the display's, which a script may let run faster. */

#include "runtime.h"

#define SECOND_NS 1000000000LL
#define AHEAD_NS (5 * SECOND_NS) /* the display's clock is another: who mixes them up is found out */

#ifdef _WIN32

static int64_t per_second(void) {
    LARGE_INTEGER frequency;
    QueryPerformanceFrequency(&frequency);
    return frequency.QuadPart;
}

static int64_t ns_of_ticks(int64_t ticks) {
    int64_t each = per_second();
    return ticks / each * SECOND_NS + ticks % each * SECOND_NS / each;
}

int64_t machine_ns(void) {
    LARGE_INTEGER now;
    QueryPerformanceCounter(&now);
    return ns_of_ticks(now.QuadPart);
}

void sleep_ns(int64_t duration_ns) {
    if (duration_ns > 0) Sleep((DWORD)((duration_ns + 999999) / 1000000));
}

XrResult xrConvertWin32PerformanceCounterToTimeKHR(XrInstance instance,
                                                   const LARGE_INTEGER *counter, XrTime *time) {
    (void)instance;
    ENTER("xrConvertWin32PerformanceCounterToTimeKHR");
    *time = display_of_machine(ns_of_ticks(counter->QuadPart));
    return XR_SUCCESS;
}

XrResult xrConvertTimeToWin32PerformanceCounterKHR(XrInstance instance, XrTime time,
                                                   LARGE_INTEGER *counter) {
    (void)instance;
    ENTER("xrConvertTimeToWin32PerformanceCounterKHR");
    int64_t ns = machine_of_display(time), each = per_second();
    counter->QuadPart = ns / SECOND_NS * each + ns % SECOND_NS * each / SECOND_NS;
    return XR_SUCCESS;
}

#else

int64_t machine_ns(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * SECOND_NS + now.tv_nsec;
}

void sleep_ns(int64_t duration_ns) {
    if (duration_ns <= 0) return;
    struct timespec duration = {duration_ns / SECOND_NS, duration_ns % SECOND_NS};
    nanosleep(&duration, NULL);
}

XrResult xrConvertTimespecTimeToTimeKHR(XrInstance instance, const struct timespec *moment,
                                        XrTime *time) {
    (void)instance;
    ENTER("xrConvertTimespecTimeToTimeKHR");
    *time = display_of_machine(moment->tv_sec * SECOND_NS + moment->tv_nsec);
    return XR_SUCCESS;
}

XrResult xrConvertTimeToTimespecTimeKHR(XrInstance instance, XrTime time,
                                        struct timespec *moment) {
    (void)instance;
    ENTER("xrConvertTimeToTimespecTimeKHR");
    int64_t ns = machine_of_display(time);
    *moment = (struct timespec){ns / SECOND_NS, ns % SECOND_NS};
    return XR_SUCCESS;
}

#endif

static int64_t began_ns;

XrTime display_of_machine(int64_t machine) {
    if (began_ns == 0) began_ns = machine_ns();
    return began_ns + AHEAD_NS + (XrTime)((double)(machine - began_ns) * settings.speed);
}

int64_t machine_of_display(XrTime time) {
    if (began_ns == 0) began_ns = machine_ns();
    return began_ns + (int64_t)((double)(time - began_ns - AHEAD_NS) / settings.speed);
}

XrTime display_now(void) { return display_of_machine(machine_ns()); }
