# Compiler flags of our own code, gathered in one interface target.
add_library(lithe_options INTERFACE)
target_compile_options(lithe_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wvla -Wstrict-prototypes -Wmissing-prototypes
  -ffp-contract=off -fno-math-errno)
if(LITHE_WERROR)
  target_compile_options(lithe_options INTERFACE -Werror)
endif()
if(LITHE_ASSERTS)
  target_compile_definitions(lithe_options INTERFACE LITHE_ASSERTS=1)
endif()
if(LITHE_SANITIZE)
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
endif()
if(LITHE_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()

# Instruction sets that kernels are compiled for, as src/base/isa.h knows them, and the options that choose them.
set(LITHE_ISAS base)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$")
  list(APPEND LITHE_ISAS v3 v4)
  set(LITHE_ISA_v3 -march=x86-64-v3)
  set(LITHE_ISA_v4 -march=x86-64-v4)
endif()
