# cmake -DOUTPUT=x.cpp "-DNAMES=kA;kB" "-DFILES=a;b" -P embed.cmake
# Writes a source file in which every file is the std::string_view of its name, declared in page_parts.h. Arrays of
# characters, because the standard promises only 65536 for a string literal.
set(source "// Made by embed.cmake.\n#include \"gyrobudget/app/report/page_parts.h\"\n\nnamespace gyrobudget::inline v0::report {\n")
foreach(name file IN ZIP_LISTS NAMES FILES)
  file(READ ${file} bytes HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${bytes}")
  string(APPEND source "static constexpr char ${name}Bytes[] = {${bytes}};\n"
                       "constinit const std::string_view ${name}(${name}Bytes, sizeof ${name}Bytes);\n")
endforeach()
file(WRITE ${OUTPUT} "${source}}  // namespace gyrobudget::inline v0::report\n")
