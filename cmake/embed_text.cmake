# cmake -DINPUT=file -DOUTPUT=file.c -DNAME=symbol -DHEADER=room/file.h -P embed_text.cmake
# A text file as a C array, so that the library needs no data files.
file(READ ${INPUT} hex HEX)
string(LENGTH "${hex}" n_digits)
math(EXPR n_bytes "${n_digits} / 2")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
string(REGEX REPLACE "(................................................................................)" "\\1\n  " bytes "${bytes}")
file(WRITE ${OUTPUT} "/// Made from ${NAME} by cmake/embed_text.cmake.
#include \"${HEADER}\"

const size_t ${NAME}_size = ${n_bytes};
const char ${NAME}[] = {
  ${bytes} 0};
")
