// Functions that the compiler builds for several instruction sets of one processor family, the widest that this machine
// has being chosen when the program starts. For plain loops over arrays that the compiler turns into SIMD by itself:
// what is written with lanes by hand lives in backends/. Results are the same whichever is chosen: the build forbids
// the compiler to fuse or to reorder floating-point operations.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define VOLCAUSTIC_SIMD_CLONES __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define VOLCAUSTIC_SIMD_CLONES
#endif
