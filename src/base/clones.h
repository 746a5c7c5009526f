/// LTH_CLONES: builds a hot kernel for several instruction sets and picks one when the program starts.
#pragma once

// gcc on x86-64 with glibc only; the sanitizers' run time is not ready when the choice is made
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__gnu_linux__) &&   \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define LTH_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define LTH_CLONES
#endif
