"""Spectroradiometers and rotation stages on a serial port: measure, log, derive."""
