# cmake -DSOURCE=FOLDER -DHEADER=FILE -P write_commit.cmake
# Writes a header that names the commit of the sources, and whether anything but reports was changed since.
# Run with every build, since a commit starts none; the file is touched only when the name is another.
#
# "unknown" where the sources are not the whole of a git repository: a copy below someone else's
# repository is not of their commit.

set(commit unknown)
find_program(GIT git)
# Where the package is a folder of links, its sources are where they lead.
get_filename_component(source ${SOURCE}/package.xml REALPATH)
get_filename_component(source ${source} DIRECTORY)

macro(git result)
  execute_process(COMMAND ${GIT} -C ${source} ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE ${result}
    ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
endmacro()

if(GIT)
  git(top rev-parse --show-toplevel)
  if(status EQUAL 0 AND top STREQUAL source)
    git(commit describe --always --abbrev=7)
    if(NOT status EQUAL 0)
      set(commit unknown)
    endif()
    git(changes status --porcelain --untracked-files=no -- . ":(exclude)benchmark/reports")
    if(changes)
      string(APPEND commit "-dirty")
    endif()
  endif()
endif()
set(header "#define MATCHBOX_SLAM_COMMIT \"${commit}\"\n")
set(header_before "")
if(EXISTS ${HEADER})
  file(READ ${HEADER} header_before)
endif()
if(NOT header_before STREQUAL header)
  file(WRITE ${HEADER} ${header})
endif()
