# How every target of this project is compiled.

option(HEADWAY_TESTS "Build the tests" ON)
option(HEADWAY_BENCH "Build the benchmarks" ON)
option(HEADWAY_FUZZ "Build the fuzzers (with clang: libFuzzer)" OFF)
option(HEADWAY_COVERAGE "Instrument for gcov" OFF)
set(HEADWAY_SANITIZE "" CACHE STRING "Sanitizers, as in -fsanitize= (address,undefined or thread)")

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  # Paths are taken relative to the tree, so that another checkout of it finds what this one compiled.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_NOHASHDIR=1
      CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} ${CCACHE_PROGRAM})
endif()

add_library(headway_options INTERFACE)
target_include_directories(headway_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(headway_options INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror -fno-math-errno -ffp-contract=off
  # gcc 12 sees overflows inside fmt and the standard library that are not there.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow -Wno-array-bounds -Wno-restrict>)
if(HEADWAY_SANITIZE)
  target_compile_options(headway_options INTERFACE
    -fsanitize=${HEADWAY_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(headway_options INTERFACE -fsanitize=${HEADWAY_SANITIZE})
endif()
if(HEADWAY_COVERAGE)
  target_compile_options(headway_options INTERFACE --coverage -fprofile-update=atomic)
  target_link_options(headway_options INTERFACE --coverage)
endif()

# headway_room(NAME LINKS ...): the library of one folder, from all .cpp files in it.
function(headway_room name)
  cmake_parse_arguments(ROOM "" "" "LINKS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  if(sources)
    add_library(headway_${name} STATIC ${sources})
    target_link_libraries(headway_${name} PUBLIC headway_options ${ROOM_LINKS})
  else()
    add_library(headway_${name} INTERFACE)
    target_link_libraries(headway_${name} INTERFACE headway_options ${ROOM_LINKS})
  endif()
endfunction()
