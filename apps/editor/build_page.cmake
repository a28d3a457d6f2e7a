# Builds the editor's page in WORK from its sources in WEB: STEP "packages", then STEP "page".
set(advice "see above. Configure with -DRELIEF_EDITOR=OFF to build without `relief view`, or with "
           "-DRELIEF_EDITOR_DIST=FOLDER for a page that was built elsewhere")

function(run_npm)
    execute_process(COMMAND ${NPM} ${ARGN} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE failed)
    if(failed)
        list(JOIN ARGN " " words)
        message(FATAL_ERROR "The editor's page can not be built: npm ${words} failed; " ${advice})
    endif()
endfunction()

if(STEP STREQUAL packages)
    file(MAKE_DIRECTORY ${WORK})
    file(COPY ${WEB}/package.json ${WEB}/package-lock.json ${WEB}/.npmrc DESTINATION ${WORK})
    run_npm(ci --no-audit --no-fund --loglevel=error)
else()
    file(REMOVE_RECURSE ${WORK}/src ${WORK}/public)
    file(COPY ${WEB}/ DESTINATION ${WORK} PATTERN node_modules EXCLUDE PATTERN dist EXCLUDE)
    run_npm(run build --loglevel=error)
endif()
file(TOUCH ${WORK}/${STEP}.stamp)
