/* Complex functions of the C runtime, which Wine 10 has as names alone; mingw's do the work.

   Arguments and results are laid out as Visual C++ has them: structures of two numbers, and a
   long double is a double. `make_complex_math_def` of scripts/windows.sh writes the exports. */

#include <complex.h>

typedef struct {
    double re, im;
} Double;
typedef struct {
    float re, im;
} Float;

#define IN(z) __builtin_complex((z).re, (z).im)
#define UNARY(name)                                 \
    Double own_##name(Double z) {                   \
        double _Complex w = name(IN(z));            \
        return (Double){creal(w), cimag(w)};        \
    }                                               \
    Float own_##name##f(Float z) {                  \
        float _Complex w = name##f(IN(z));          \
        return (Float){crealf(w), cimagf(w)};       \
    }
#define MEASURE(name)                                         \
    double own_##name(Double z) { return name(IN(z)); }       \
    float own_##name##f(Float z) { return name##f(IN(z)); }

UNARY(cacos)
UNARY(cacosh)
UNARY(casin)
UNARY(casinh)
UNARY(catan)
UNARY(catanh)
UNARY(ccos)
UNARY(ccosh)
UNARY(cexp)
UNARY(clog)
UNARY(conj)
UNARY(cproj)
UNARY(csin)
UNARY(csinh)
UNARY(csqrt)
UNARY(ctan)
UNARY(ctanh)
MEASURE(cabs)
MEASURE(carg)
MEASURE(cimag)
MEASURE(creal)

Double own_cpow(Double z, Double power) {
    double _Complex w = cpow(IN(z), IN(power));
    return (Double){creal(w), cimag(w)};
}

Float own_cpowf(Float z, Float power) {
    float _Complex w = cpowf(IN(z), IN(power));
    return (Float){crealf(w), cimagf(w)};
}
