MODULE SeamtrackEGM
    ! ABB EGM path correction for `seamtrack live`: docs/live.md says what goes with it. Put in your own points, tool and speed.
    VAR egmident egmSeam;
    PERS tooldata tTorch := [TRUE, [[0, 0, 300], [1, 0, 0, 0]], [2, [0, 0, 150], [1, 0, 0, 0], 0, 0, 0]];
    CONST robtarget pStart := [[500, -250, 200], [0, 0, 1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
    CONST robtarget pEnd := [[500, 250, 200], [0, 0, 1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
    CONST speeddata vWeld := [10, 500, 5000, 1000];

    PROC WeldSeam()
        ! Path correction begins and ends at rest.
        MoveJ pStart, v100, fine, tTorch;
        EGMReset egmSeam;
        EGMGetId egmSeam;
        ! "pathCorr": External Motion Interface Data, level Path. "Seamtrack": the UDPUC device.
        ! CommTimeout: the robot stops after this silence [s], which is our STOP.
        EGMSetupUC ROB_1, egmSeam, "pathCorr", "Seamtrack" \PathCorr \APTR \CommTimeout := 1;
        EGMActMove egmSeam, tTorch.tframe \SampleRate := 24;
        EGMMoveL egmSeam, pEnd, vWeld, fine, tTorch;
        EGMReset egmSeam;
    ERROR
        ! No answer for CommTimeout: the torch stands. Arc off here; go on by a new EGMMoveL from where it stands.
        EGMReset egmSeam;
        RAISE;
    ENDPROC
ENDMODULE
