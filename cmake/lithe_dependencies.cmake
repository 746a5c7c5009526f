# Third-party libraries, gathered in one interface target.
find_package(PkgConfig REQUIRED)
find_package(OpenMP REQUIRED COMPONENTS C)
find_package(ZLIB REQUIRED)
find_package(PNG REQUIRED)
find_package(BLAS REQUIRED)
find_package(LAPACK REQUIRED)
pkg_check_modules(FYAML REQUIRED IMPORTED_TARGET libfyaml)
find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
find_library(MUPARSER_LIBRARY muparser REQUIRED)
find_path(MUPARSER_INCLUDE_DIR muParserDLL.h REQUIRED)
find_path(LAPACKE_INCLUDE_DIR lapacke.h REQUIRED)
find_library(LAPACKE_LIBRARY lapacke REQUIRED)

add_library(lithe_dependencies INTERFACE)
target_include_directories(lithe_dependencies SYSTEM INTERFACE
  ${CHOLMOD_INCLUDE_DIR} ${MUPARSER_INCLUDE_DIR} ${LAPACKE_INCLUDE_DIR})
target_link_libraries(lithe_dependencies INTERFACE
  PkgConfig::FYAML PNG::PNG ZLIB::ZLIB ${CHOLMOD_LIBRARY} ${MUPARSER_LIBRARY} ${LAPACKE_LIBRARY}
  LAPACK::LAPACK BLAS::BLAS OpenMP::OpenMP_C m)
